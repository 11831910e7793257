// Files under numbers that are not taken; what fails is a sentence.
// Mirrors app/session/file_keeper.h.
#include "app/session/file_keeper.h"

#include <gmock/gmock.h>

#include <stdexcept>

#include "tests/test_folder.h"
#include "tests/wait_for.h"

namespace warpscope {
namespace {

std::string noteOf(FileKeeper& keeper) {
  return waitFor([&] { return keeper.takeNote(); });
}

FileKeeper::File file(const std::string& ending, const std::string& text) {
  return {ending, [text] { return text; }};
}

TEST(FileKeeper, NamesAreThoseThatNobodyHas) {
  const TestFolder folder;
  FileKeeper keeper(folder.path(), [] {});
  folder.write("warpscope-7-1-spheres.png", "");
  folder.write("warpscope-12x", "");
  folder.write("warpscope-.png", "");
  keeper.keep({file(".png", "a")});
  EXPECT_THAT(noteOf(keeper), testing::HasSubstr("warpscope-8.png"));
  EXPECT_EQ(folder.read("warpscope-8.png"), "a");
  keeper.keep({file("-1.png", "b"), file("-2.png", "c")});
  EXPECT_THAT(noteOf(keeper), testing::EndsWith("warpscope-9-1.png and warpscope-9-2.png"));
  EXPECT_EQ(folder.read("warpscope-9-2.png"), "c");
  keeper.keep({});
  EXPECT_FALSE(keeper.takeNote());
}

TEST(FileKeeper, ManyAtATimeTakeANumberEach) {
  const TestFolder folder;
  FileKeeper keeper(folder.path(), [] {});
  for (int i = 0; i < 20; ++i) keeper.keep({file(".png", std::to_string(i))});
  for (int i = 0; i < 20; ++i) EXPECT_THAT(noteOf(keeper), testing::StartsWith("saved "));
  EXPECT_TRUE(std::filesystem::exists(folder.path() / "warpscope-20.png"));
}

TEST(FileKeeper, WhatFailsIsASentenceAndLeavesNothing) {
  const TestFolder folder;
  FileKeeper keeper(folder.path(), [] {});
  keeper.keep({file("-1.png", "a"), {"-2.png", []() -> std::string { throw std::runtime_error("no memory for that"); }}});
  EXPECT_EQ(noteOf(keeper), "no memory for that");
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
  // Nor where one of them cannot be written.
  keeper.keep({file("-1.png", "a"), file("/2.png", "b")});
  EXPECT_THAT(noteOf(keeper), testing::HasSubstr("cannot be written"));
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
  FileKeeper nowhere(folder.path() / "missing", [] {});
  nowhere.keep({file(".png", "a")});
  EXPECT_THAT(noteOf(nowhere), testing::HasSubstr("warpscope-1.png"));
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "missing"));
}

}  // namespace
}  // namespace warpscope
