// Every heuristic, for tests that have a case for each.
#pragma once

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "render/march/march_settings.h"

namespace warpscope {

inline std::vector<Heuristic> everyHeuristic() {
  std::vector<Heuristic> all;
  for (const auto& heuristic : kHeuristics) all.push_back(heuristic.value);
  return all;
}

/// Test names have no hyphens.
inline std::string heuristicCase(const testing::TestParamInfo<Heuristic>& info) {
  std::string name(nameOf(info.param));
  std::erase(name, '-');
  return name;
}

}  // namespace warpscope
