// Files that tests of readers write, and how their refusals are checked.
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <random>
#include <string>
#include <vector>

#include "render/base/error.h"
#include "render/volume/reader.h"
#include "tests/test_folder.h"

namespace warpscope {

namespace fs = std::filesystem;
using testing::HasSubstr;

class Reader : public testing::Test {
 protected:
  fs::path write(const std::string& name, const std::string& bytes) const { return folder_.write(name, bytes); }

  /// Expects an InputError of one line that names the file and says `reason`; nothing may appear on stderr.
  void expectRefused(const fs::path& path, const std::string& reason) const {
    testing::internal::CaptureStderr();
    std::string text = "(nothing was thrown)";
    try {
      openVolume(path);
    } catch (const InputError& error) {
      text = error.what();
    }
    EXPECT_THAT(text, HasSubstr(reason)) << path;
    EXPECT_THAT(text, HasSubstr(path.filename().string()));
    EXPECT_THAT(text, testing::Not(HasSubstr("\n")));
    EXPECT_EQ(testing::internal::GetCapturedStderr(), "") << path;
  }

  const TestFolder folder_;
  const fs::path directory_ = folder_.path();
};

template <class T>
std::string bytesOf(const std::vector<T>& values) {
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
}

}  // namespace warpscope
