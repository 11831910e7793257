// What lies between the rays of a frame's pixels. For host and device.
#pragma once

#include <type_traits>

namespace warpscope {

enum class Between {
  nearest,  ///< what the nearest pixel has
  linear,   ///< what the four pixels about it have, blended
  refined,  ///< the same; where they disagree, what the copy of the volume has
};

/// What it is without a copy.
constexpr Between unfilled(Between between) { return between == Between::refined ? Between::linear : between; }

constexpr bool blends(Between between) { return between != Between::nearest; }

/// Calls f(constant) with `between` as a constant of the compiler's.
template <class F>
void visitBetween(Between between, F&& f) {
  switch (between) {
    case Between::nearest: return f(std::integral_constant<Between, Between::nearest>());
    case Between::linear: return f(std::integral_constant<Between, Between::linear>());
    case Between::refined: return f(std::integral_constant<Between, Between::refined>());
  }
}

}  // namespace warpscope
