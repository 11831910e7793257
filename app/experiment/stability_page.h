// The page of `stability`: every case with its pictures, the errors of both forms, the bound, and what stability costs.
// One HTML file that needs nothing else.
#pragma once

#include <string>
#include <vector>

#include "app/experiment/stability.h"

namespace warpscope {

/// "2.1e-07", or "0".
std::string errorText(double value);

/// `machine`: on what it was run, in words.
std::string stabilityPage(const std::vector<StabilityResult>& results, const std::string& machine);

}  // namespace warpscope
