// Whether the pixels about a cell show the same of what a ray goes through in it. For host and device.
#pragma once

#include "render/core/numeric.h"

namespace warpscope {

/// By how much of full light or opacity, behind what is in front, pixels may differ in what they show that are taken to continue each other. What other limits are worth: tests/bench.
inline constexpr float kMostDisagreement = 1.0f / 16;

/// What each of four pixels shows of a stretch, as if a ray kept to it. `Number`: float, or a vector of as many rays as it has lanes.
template <class Number>
struct PixelViews {
  static constexpr int kPixels = 4;
  Number color[kPixels][3];  ///< linear, premultiplied
  Number asked[kPixels];     ///< 1 of those that are compared, else 0

  WARPSCOPE_HD void clear() {
    for (int i = 0; i < kPixels; ++i) {
      asked[i] = Number(0.0f);
      for (Number& channel : color[i]) channel = Number(0.0f);
    }
  }

  /// `left`: of light that goes along what each has. Of those that are compared the largest difference of a channel or of opacity.
  WARPSCOPE_HD Number disagreement(const Number (&left)[kPixels]) const {
    Number most(0.0f);
    for (int channel = 0; channel < 4; ++channel) {
      Number highest(0.0f), lowest(kAboveAll);
      for (int i = 0; i < kPixels; ++i) {
        const Number shown = channel < 3 ? color[i][channel % 3] : 1.0f - left[i];
        highest = maxOf(highest, asked[i] * shown);
        lowest = minOf(lowest, mulAdd(1.0f - asked[i], Number(kAboveAll), shown));
      }
      most = maxOf(most, highest - lowest);
    }
    return most;
  }

 private:
  static constexpr float kAboveAll = 1e9f;
};

}  // namespace warpscope
