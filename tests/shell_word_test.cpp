// Words for a shell: taken apart by one, they are what they were.
#include "render/base/shell_word.h"

#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <string>

namespace warpscope {
namespace {

std::string echoed(const std::string& word) {
  const std::string command = "printf '%s|' " + word;
  FILE* const shell = ::popen(command.c_str(), "r");
  if (shell == nullptr) return "no shell";
  std::string text;
  std::array<char, 256> part{};
  for (size_t length; (length = std::fread(part.data(), 1, part.size(), shell)) > 0;) text.append(part.data(), length);
  ::pclose(shell);
  return text;
}

TEST(ShellWord, AShellTakesItForOneWord) {
  for (const std::string text : {"plain", "", " ", "a b", "it's", "''", "$HOME", "`id`", "a\nb", "*", "~", "#x", "a;b", "-n", "\\", "\"", "!", "{a,b}", "\xc3\xa4 \xff", "a&b|c>d"})
    EXPECT_EQ(echoed(shellWord(text)), text + "|") << shellWord(text);
}

TEST(ShellWord, PlainOnesStayAsTheyAre) {
  EXPECT_EQ(shellWord("/data/engine_256x256x128_uint8.raw"), "/data/engine_256x256x128_uint8.raw");
  EXPECT_EQ(shellWord("127.0.0.1:4711,a=b@c%d+e"), "127.0.0.1:4711,a=b@c%d+e");
}

}  // namespace
}  // namespace warpscope
