# Run by warpscope_embed at build time: writes OUTPUT.h and OUTPUT.cpp that hold FILES (separated by |) as bytes.
string(REPLACE "|" ";" files "${FILES}")
file(WRITE ${OUTPUT}.h "// Generated: files compiled into the program.
#pragma once

#include <span>
#include <string_view>

namespace warpscope::${NAMESPACE} {

struct File {
  std::string_view name;     // without its folder
  std::string_view content;
};

std::span<const File> files();

/// Content of the named file; empty if there is none of that name.
std::string_view find(std::string_view name);

}  // namespace warpscope::${NAMESPACE}
")
set(arrays "")
set(entries "")
set(index 0)
foreach(file IN LISTS files)
  get_filename_component(name ${file} NAME)
  file(READ ${file} hex HEX)
  string(LENGTH "${hex}" digits)
  math(EXPR bytes "${digits} / 2")
  string(REGEX REPLACE "([0-9a-f][0-9a-f])" "\\\\x\\1" escaped "${hex}")

  string(APPEND arrays "const char file${index}[] =\n    \"${escaped}\";\n")
  string(APPEND entries "    {\"${name}\", {file${index}, ${bytes}}},\n")
  math(EXPR index "${index} + 1")
endforeach()
file(WRITE ${OUTPUT}.cpp "// Generated: files compiled into the program.
#include \"${NAMESPACE}.h\"

namespace warpscope::${NAMESPACE} {
namespace {

${arrays}
const File kFiles[] = {
${entries}};

}  // namespace

std::span<const File> files() { return kFiles; }

std::string_view find(std::string_view name) {
  for (const File& file : kFiles)
    if (file.name == name) return file.content;
  return {};
}

}  // namespace warpscope::${NAMESPACE}
")
