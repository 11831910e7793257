// What effects cost the server and add to techniques' errors, by what a sweep measured with and without them.
// Each technique is compared with the ground truth of the same effects: what a warp carries along wrongly, highlights and shadows, is its error.
#pragma once

#include <string>
#include <vector>

#include "app/experiment/findings.h"

namespace warpscope {

/// A sentence, on its own line, for each knob of an effect that has several values in `summaries`: of the greatest against the least, over all pairs of
/// configurations that differ in it alone. Empty if there is none.
std::string effectSentences(const std::vector<Summary>& summaries);

}  // namespace warpscope
