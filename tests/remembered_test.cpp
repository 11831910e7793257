// What windows remember comes back; what is damaged is forgotten, and nothing else is.
// Mirrors app/session/remembered.h.
#include "app/session/remembered.h"

#include <gmock/gmock.h>

#include "render/base/error.h"
#include "tests/test_folder.h"

namespace warpscope {
namespace {

TEST(Remembered, ComesBack) {
  const TestFolder folder;
  Remembered remembered;
  remembered.windowSize = glm::uvec2(900, 700);
  remembered.isLight = true;
  remembered.hasSideBar = false;
  remembered.setFolded("SERVER", true);
  remembered.setFolded("NETWORK", true);
  remembered.setFolded("NETWORK", false);
  for (int i = 0; i < 20; ++i) remembered.addFile(folder.path() / (std::to_string(i) + ".json"));
  remembered.addFile(folder.path() / "17.json");
  ASSERT_EQ(remembered.recentFiles.size(), Remembered::kMostRecent);
  EXPECT_EQ(remembered.recentFiles[0], (folder.path() / "17.json").string()) << "the newest first, and once";
  EXPECT_EQ(remembered.recentFiles[1], (folder.path() / "19.json").string());
  const std::filesystem::path file = folder.path() / "deep" / "inside" / "window.json";
  writeRemembered(file, remembered);
  EXPECT_EQ(readRemembered(file), remembered);
}

TEST(Remembered, WhatIsDamagedIsForgottenAlone) {
  const TestFolder folder;
  const auto read = [&](const std::string& text) { return readRemembered(folder.write("window.json", text)); };
  EXPECT_EQ(readRemembered(folder.path() / "missing.json"), Remembered{});
  for (const char* text : {"", "[]", "{", "{}", "null", "{\"size\": [0, 1], \"theme\": 3, \"folded\": {}, \"recentFiles\": [1]}"}) EXPECT_EQ(read(text), Remembered{}) << text;
  const Remembered half = read(R"({"size": "large", "theme": "light", "folded": ["SERVER"], "later": 1})");
  EXPECT_TRUE(half.isLight);
  EXPECT_TRUE(half.folded.contains("SERVER"));
  EXPECT_FALSE(half.windowSize);
  EXPECT_EQ(readRemembered(folder.path()), Remembered{}) << "a folder";
  folder.write("plain", "");
  EXPECT_THROW(writeRemembered(folder.path() / "plain" / "window.json", {}), InputError);
}

}  // namespace
}  // namespace warpscope
