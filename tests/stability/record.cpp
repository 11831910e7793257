// One JSON file for each test that has rows.
// See record.h.
#include "tests/stability/record.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <regex>
#include <vector>

namespace warpscope {
namespace {

using nlohmann::json;

/// What the running test has recorded so far: a test may be repeated in one process, and its file is written anew then.
std::map<std::string, json> rowsOfTests;

}  // namespace

void record(const Record& row) {
  EXPECT_LE(row.worst, row.bound) << row.function << ", " << row.unit;
  const char* const folder = std::getenv("WARPSCOPE_STABILITY_RECORDS");
  if (folder == nullptr || *folder == '\0') return;
  const testing::TestInfo& test = *testing::UnitTest::GetInstance()->current_test_info();
  std::string name = std::string(test.test_suite_name()) + "." + test.name();
  std::smatch number;
  if (!std::regex_search(name, number, std::regex(R"((?:^|/)Case(\d\d)\.)"))) {
    ADD_FAILURE() << name << " has no case: its suite must be named Case and two digits";
    return;
  }
  json& rows = rowsOfTests[name];
  if (rows.is_null()) rows = json::array();
  json fresh{{"case", std::stoi(number[1])},
             {"what", row.function},
             {"unit", row.unit},
             {"oracle", row.oracle},
             {"bound", row.bound},
             {"backend", std::string(nameOf(row.backend))},
             {"worst", std::isfinite(row.worst) ? json(row.worst) : json("infinite")}};
  const auto isSameRow = [&](const json& other) {
    return other["what"] == fresh["what"] && other["oracle"] == fresh["oracle"] && other["backend"] == fresh["backend"];
  };
  const auto old = std::find_if(rows.begin(), rows.end(), isSameRow);
  if (old != rows.end())
    *old = fresh;
  else
    rows.push_back(fresh);
  std::replace(name.begin(), name.end(), '/', '_');
  std::error_code ignored;  // what matters is whether the file can be written
  std::filesystem::create_directories(folder, ignored);
  std::ofstream file(std::filesystem::path(folder) / (name + ".json"));
  file << rows.dump(1) << '\n';
  file.close();
  EXPECT_TRUE(file) << "the row could not be written into " << folder;
}

void recordExact(const std::string& function, const std::string& oracle, Backend backend) {
  const bool isRight = !testing::Test::HasFailure();
  record({.function = function,
          .oracle = oracle,
          .unit = "",
          .worst = isRight ? 0.0 : std::numeric_limits<double>::infinity(),
          .bound = 0.0,
          .backend = backend});
}

}  // namespace warpscope
