// Which way a double is rounded to a float.
#pragma once

#include <cmath>
#include <limits>

namespace warpscope {

/// The largest float that is at most `value`.
inline float roundedDown(double value) {
  const auto nearest = static_cast<float>(value);
  return static_cast<double>(nearest) > value ? std::nextafter(nearest, -std::numeric_limits<float>::infinity()) : nearest;
}

/// The least float that is at least `value`.
inline float roundedUp(double value) {
  const auto nearest = static_cast<float>(value);
  return static_cast<double>(nearest) < value ? std::nextafter(nearest, std::numeric_limits<float>::infinity()) : nearest;
}

}  // namespace warpscope
