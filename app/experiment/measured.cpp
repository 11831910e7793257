// Median and quartiles.
// See measured.h.
#include "app/experiment/measured.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace warpscope {

Measured measuredOf(std::vector<double> timesMs) {
  std::sort(timesMs.begin(), timesMs.end());
  const auto at = [&](double share) {  // between neighbours by linear interpolation
    const double place = share * static_cast<double>(timesMs.size() - 1);
    const auto below = static_cast<size_t>(place);
    const size_t above = std::min(below + 1, timesMs.size() - 1);
    return std::lerp(timesMs[below], timesMs[above], place - static_cast<double>(below));
  };
  return {at(0.5), at(0.75) - at(0.25)};
}

}  // namespace warpscope
