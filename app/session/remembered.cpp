// To JSON and back.
// See remembered.h.
#include "app/session/remembered.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "app/scene/json_document.h"
#include "app/shell/log.h"
#include "app/shell/output_files.h"
#include "render/base/error.h"

namespace warpscope {
namespace {

/// What `f` reads; of what cannot be read, nothing.
template <class F>
void tryReading(F&& f) {
  try {
    f();
  } catch (const InputError& error) {
    logDetail(error.what());
  }
}

}  // namespace

void Remembered::addFile(const std::filesystem::path& path) {
  std::error_code failed;
  const std::filesystem::path absolute = std::filesystem::absolute(path, failed);
  const std::string name = (failed ? path : absolute).string();
  std::erase(recentFiles, name);
  recentFiles.insert(recentFiles.begin(), name);
  if (recentFiles.size() > kMostRecent) recentFiles.resize(kMostRecent);
}

void Remembered::setFolded(const std::string& section, bool isFolded) {
  if (isFolded)
    folded.insert(section);
  else
    folded.erase(section);
}

Remembered readRemembered(const std::filesystem::path& file) {
  constexpr size_t kMostFolded = 100;
  Remembered remembered;
  std::error_code ignored;
  if (!std::filesystem::exists(file, ignored)) return remembered;
  tryReading([&] {
    const JsonDocument document = JsonDocument::fromFile(file);
    const Node root = document.root();
    tryReading([&] {
      if (const auto size = root.find("size")) {
        const std::vector<Node> edges = size->elements(2, 2);
        remembered.windowSize = glm::uvec2(edges[0].integer(1, 65536), edges[1].integer(1, 65536));
      }
    });
    tryReading([&] {
      if (const auto theme = root.find("theme")) remembered.isLight = theme->string() == "light";
    });
    tryReading([&] {
      if (const auto bar = root.find("sideBar")) remembered.hasSideBar = bar->boolean();
    });
    tryReading([&] {
      if (const auto folded = root.find("folded"))
        for (const Node& section : folded->elements(0, kMostFolded)) remembered.folded.insert(section.string());
    });
    tryReading([&] {
      if (const auto files = root.find("recentFiles"))
        for (const Node& path : files->elements(0, Remembered::kMostRecent)) remembered.recentFiles.push_back(path.string());
    });
  });
  return remembered;
}

void writeRemembered(const std::filesystem::path& file, const Remembered& remembered) {
  nlohmann::json json{{"theme", remembered.isLight ? "light" : "dark"},
                      {"sideBar", remembered.hasSideBar},
                      {"folded", remembered.folded},
                      {"recentFiles", remembered.recentFiles}};
  if (remembered.windowSize) json["size"] = {remembered.windowSize->x, remembered.windowSize->y};
  std::error_code ignored;
  std::filesystem::create_directories(file.parent_path(), ignored);
  writeFileWhole(file, textOf(json));
}

}  // namespace warpscope
