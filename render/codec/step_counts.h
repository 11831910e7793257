// How many steps rays have in the volume, many at once.
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>

#include "render/march/lattice.h"

namespace warpscope {

/// makeLattice()'s, of rays that are so long inside, without a division for each. `lengths` and `step` may be anything.
inline void countSteps(std::span<const float> lengths, float step, std::span<int32_t> counts) {
  const float* const length = lengths.data();
  int32_t* const count = counts.data();
  uint32_t longest = 0;  // as bits without the sign, which rise with numbers; those of what is no number are above them all
  for (size_t k = 0; k < lengths.size(); ++k) longest = std::max(longest, std::bit_cast<uint32_t>(length[k]) & 0x7fffffffu);
  // Up to so many steps, a product with dt is exact. One with its reciprocal, rounded down, is the quotient rounded down
  // or up, or one less than a quotient that is whole: where it is too few for the length, one more is right.
  constexpr double kMost = 1 << 29;
  const double dt = step, perLength = 1.0 / dt;
  if (!(dt > 0.0 && static_cast<double>(std::bit_cast<float>(longest)) * perLength < kMost)) {
    for (size_t k = 0; k < lengths.size(); ++k) count[k] = makeLattice({0.0f, length[k]}, step).count;
    return;
  }
  for (size_t k = 0; k < lengths.size(); ++k) {
    const double own = length[k], about = std::floor(own * perLength), steps = about * dt < own ? about + 1.0 : about;
    count[k] = steps >= 1.0 ? static_cast<int32_t>(steps) : 0;
  }
}

}  // namespace warpscope
