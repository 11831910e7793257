// Files that tests of readers write, and how their refusals are checked.
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <filesystem>
#include <fstream>
#include <random>
#include <string>
#include <vector>

#include "render/base/error.h"
#include "render/volume/reader.h"

namespace warpscope {

namespace fs = std::filesystem;
using testing::HasSubstr;

/// A directory of its own for every test.
class Reader : public testing::Test {
 protected:
  void SetUp() override {
    static std::atomic<int> count = 0;
    const auto* info = testing::UnitTest::GetInstance()->current_test_info();
    directory_ = fs::temp_directory_path() / ("warpscope_" + std::string(info->name()) + "_" +
                                              std::to_string(std::random_device{}()) + "_" + std::to_string(count++));
    fs::create_directories(directory_);
  }
  void TearDown() override {
    std::error_code ignored;
    fs::remove_all(directory_, ignored);
  }

  fs::path write(const std::string& name, const std::string& bytes) const {
    std::ofstream(directory_ / name, std::ios::binary) << bytes;
    return directory_ / name;
  }

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

  fs::path directory_;
};

template <class T>
std::string bytesOf(const std::vector<T>& values) {
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
}

}  // namespace warpscope
