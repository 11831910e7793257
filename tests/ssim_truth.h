// The oracle of SSIM: one channel, window by window, in long double. Shares nothing with what it judges.
// Wang, Bovik, Sheikh, Simoncelli 2004, section III B: an 11x11 Gaussian window of 1.5 pixels, K1 = 0.01, K2 = 0.03.
#pragma once

#include <cmath>
#include <cstddef>
#include <vector>

namespace warpscope {

using Levels = std::vector<long double>;  // of one channel, as displayed, row by row

/// The mean over all pixels whose window lies inside. Both of one size, `width` pixels wide, at least 11 a side.
inline long double ssimTruth(const Levels& a, const Levels& b, int width) {
  constexpr int kRadius = 5;
  const int height = static_cast<int>(a.size()) / width;
  long double weights[2 * kRadius + 1], sum = 0.0L, total = 0.0L;
  for (int i = -kRadius; i <= kRadius; ++i) sum += weights[i + kRadius] = std::exp(-0.5L * i * i / 2.25L);
  int count = 0;
  for (int y = kRadius; y < height - kRadius; ++y)
    for (int x = kRadius; x < width - kRadius; ++x, ++count) {
      const auto mean = [&](const auto& value) {
        long double result = 0.0L;
        for (int j = -kRadius; j <= kRadius; ++j)
          for (int i = -kRadius; i <= kRadius; ++i)
            result += weights[i + kRadius] * weights[j + kRadius] / (sum * sum) *
                      value(static_cast<size_t>(y + j) * static_cast<size_t>(width) + static_cast<size_t>(x + i));
        return result;
      };
      const long double ma = mean([&](size_t i) { return a[i]; }), mb = mean([&](size_t i) { return b[i]; });
      const long double va = mean([&](size_t i) { return (a[i] - ma) * (a[i] - ma); }),
                        vb = mean([&](size_t i) { return (b[i] - mb) * (b[i] - mb); });
      const long double cov = mean([&](size_t i) { return (a[i] - ma) * (b[i] - mb); });
      constexpr long double c1 = 1e-4L, c2 = 9e-4L;
      total += (2 * ma * mb + c1) * (2 * cov + c2) / ((ma * ma + mb * mb + c1) * (va + vb + c2));
    }
  return total / count;
}

}  // namespace warpscope
