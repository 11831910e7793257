// Median and quartiles.
// See measured.h.
#include "app/measured.h"

#include <algorithm>
#include <cstddef>

namespace warpscope {

Measured measuredOf(std::vector<double> timesMs) {
  std::sort(timesMs.begin(), timesMs.end());
  const auto at = [&](double share) { return timesMs[static_cast<size_t>(share * static_cast<double>(timesMs.size() - 1) + 0.5)]; };
  return {at(0.5), at(0.75) - at(0.25)};
}

}  // namespace warpscope
