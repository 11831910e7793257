// What structural similarity is made of, for one pixel or a vector of them, on host and device.
// Wang, Bovik, Sheikh, Simoncelli 2004, section III B; see ssim.h.
#pragma once

#include <array>
#include <cmath>

#include "render/core/numeric.h"

namespace warpscope {

inline constexpr int kSsimRadius = 5;  ///< of the window, pixels

/// The window along one axis; its taps sum up to 1 to a few 1e-9: what is missing would look like a variance of flat areas.
inline std::array<float, 2 * kSsimRadius + 1> ssimWindow() {
  constexpr double kDeviation = 1.5;
  const auto weight = [](int i) { return std::exp(-0.5 * i * i / (kDeviation * kDeviation)); };
  double sum = 0.0;
  for (int i = -kSsimRadius; i <= kSsimRadius; ++i) sum += weight(i);
  std::array<float, 2 * kSsimRadius + 1> taps;
  double rest = 1.0;  // of the middle one, rounded last
  for (int i = -kSsimRadius; i <= kSsimRadius; ++i) {
    if (i == 0) continue;
    float& tap = taps[static_cast<size_t>(i + kSsimRadius)];
    tap = static_cast<float>(weight(i) / sum);
    rest -= static_cast<double>(tap);
  }
  taps[kSsimRadius] = static_cast<float>(rest);
  return taps;
}

/// Values 0..1 are taken relative to this one: their squares are then at most 1/4, and so is what rounding does to variances.
inline constexpr float kSsimCenter = 0.5f;

/// Of a window of values 0..1, from the means of both sides less kSsimCenter, their variances, and the mean of their squared differences. In [-1, 1]; 1 for
/// sides that are equal. By differences of the sides: 1 - (a - b)^2 / (a^2 + b^2 + c1) is (2ab + c1) / (a^2 + b^2 + c1), and likewise for variances, but
/// what rounding takes is a part of the dissimilarity instead of c2 = 0.0009.
template <class Real>
WARPSCOPE_HD inline Real ssimOf(const Real& meanA, const Real& meanB, const Real& varianceA, const Real& varianceB, const Real& squaredDifference) {
  const Real c1(0.01f * 0.01f), c2(0.03f * 0.03f), zero(0.0f), one(1.0f), center(kSsimCenter);
  const Real apart = meanA - meanB, wholeA = meanA + center, wholeB = meanB + center;
  const Real variances = maxOf(varianceA, zero) + maxOf(varianceB, zero);
  const Real varianceApart = minOf(maxOf(squaredDifference - apart * apart, zero), variances + variances);
  return (one - apart * apart / (wholeA * wholeA + wholeB * wholeB + c1)) * (one - varianceApart / (variances + c2));
}

}  // namespace warpscope
