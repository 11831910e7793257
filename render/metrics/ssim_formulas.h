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

/// Of a window, from the means of both sides, their variances and their covariance, of values 0..1.
template <class Real>
WARPSCOPE_HD inline Real ssimOf(const Real& meanA, const Real& meanB, const Real& varianceA, const Real& varianceB, const Real& covariance) {
  const Real c1(0.01f * 0.01f), c2(0.03f * 0.03f), two(2.0f);
  return (two * meanA * meanB + c1) * (two * covariance + c2) / ((meanA * meanA + meanB * meanB + c1) * (varianceA + varianceB + c2));
}

}  // namespace warpscope
