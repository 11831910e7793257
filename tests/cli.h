// What tests of the command line share: a folder to work in, small pictures, and what a refusal looks like.
// The contract: exit codes 0 (success), 1 (failure), 2 (usage); one sentence on stderr; nothing half-written stays behind.
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "app/picture/picture.h"
#include "tests/run_program.h"

namespace warpscope {

constexpr int kSuccess = 0, kFailure = 1, kUsage = 2;

class CommandLine : public testing::Test {
 protected:
  /// Options that make any scene quick to draw.
  static Arguments quick(Arguments arguments, const std::string& size = "40x30") {
    arguments.insert(arguments.end(), {"--volume-size", "24x22x20", "--size", size});
    return arguments;
  }

  ProgramResult run(const Arguments& arguments, const Arguments& environment = {}) const {
    return runProgram(arguments, folder_.path(), environment);
  }

  /// Runs a command that must succeed.
  ProgramResult succeed(const Arguments& arguments, const Arguments& environment = {}) const {
    ProgramResult result = run(arguments, environment);
    EXPECT_EQ(result.code, kSuccess) << testing::PrintToString(arguments) << "\n" << result.err;
    return result;
  }

  /// Runs a command that must succeed and print one JSON document and nothing else; null if it does not.
  nlohmann::json document(const Arguments& arguments) const {
    const ProgramResult result = succeed(arguments);
    nlohmann::json parsed = nlohmann::json::parse(result.out, nullptr, false);  // the whole text: anything after it is an error
    EXPECT_FALSE(parsed.is_discarded()) << result.out;
    return parsed.is_discarded() ? nlohmann::json() : parsed;
  }

  /// Runs a command that must fail with `code`, say why in one line that contains each of `reasons`, print nothing on stdout and leave the
  /// folder as it was.
  void expectRefused(const Arguments& arguments, int code, const std::vector<std::string>& reasons) const {
    SCOPED_TRACE(testing::PrintToString(arguments));
    const std::vector<std::string> before = folder_.listing();
    const ProgramResult result = run(arguments);
    EXPECT_EQ(result.code, code);
    EXPECT_EQ(result.out, "");
    EXPECT_THAT(result.err, testing::StartsWith("warpscope: "));
    EXPECT_THAT(result.err, testing::EndsWith("\n"));
    EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
    EXPECT_GT(result.err.size(), 25u) << "too short to help: " << result.err;
    EXPECT_LT(result.err.size(), 600u) << result.err;
    for (const std::string& reason : reasons) EXPECT_THAT(result.err, testing::HasSubstr(reason));
    for (const char* noise : {"terminate called", "what():", "std::", "basic_", "Segmentation", "itk::", "json.exception", "filesystem error"})
      EXPECT_THAT(result.err, testing::Not(testing::HasSubstr(noise)));
    EXPECT_EQ(folder_.listing(), before) << "something was left behind";
  }

  /// A PNG file of the folder.
  Image<Rgba8> picture(const std::string& name) const { return readPng(folder_.file(name)); }

  const TestFolder folder_;
};

}  // namespace warpscope
