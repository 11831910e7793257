// Errors of pictures: cases 56 and 58. Truth: the formulas in long double, by brute force over every window.
// Mirrors render/metrics/ssim.h. What other implementations say: picture_metrics_test.cpp, metrics_oracles_test.py.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "render/core/color.h"
#include "render/metrics/ssim.h"
#include "render/metrics/ssim_formulas.h"

namespace warpscope {
namespace {

const glm::vec3 kBlack(0.0f);
constexpr uint32_t kSide = 24;

using Levels = std::vector<long double>;  // of one channel, as displayed

long double ssimTruth(const Levels& a, const Levels& b) {
  long double weights[2 * kSsimRadius + 1], sum = 0.0L, total = 0.0L;
  for (int i = -kSsimRadius; i <= kSsimRadius; ++i) sum += weights[i + kSsimRadius] = std::exp(-0.5L * i * i / 2.25L);
  int count = 0;
  for (int y = kSsimRadius; y < static_cast<int>(kSide) - kSsimRadius; ++y)
    for (int x = kSsimRadius; x < static_cast<int>(kSide) - kSsimRadius; ++x, ++count) {
      const auto mean = [&](const auto& value) {
        long double result = 0.0L;
        for (int j = -kSsimRadius; j <= kSsimRadius; ++j)
          for (int i = -kSsimRadius; i <= kSsimRadius; ++i)
            result += weights[i + kSsimRadius] * weights[j + kSsimRadius] / (sum * sum) * value(static_cast<size_t>(y + j) * kSide + static_cast<size_t>(x + i));
        return result;
      };
      const long double ma = mean([&](size_t i) { return a[i]; }), mb = mean([&](size_t i) { return b[i]; });
      const long double va = mean([&](size_t i) { return (a[i] - ma) * (a[i] - ma); }), vb = mean([&](size_t i) { return (b[i] - mb) * (b[i] - mb); });
      const long double cov = mean([&](size_t i) { return (a[i] - ma) * (b[i] - mb); });
      constexpr long double c1 = 1e-4L, c2 = 9e-4L;
      total += (2 * ma * mb + c1) * (2 * cov + c2) / ((ma * ma + mb * mb + c1) * (va + vb + c2));
    }
  return total / count;
}

/// Grey, opaque; and what it shows, which is not quite what was asked for.
Image<glm::vec4> pictureOf(Levels& levels) {
  Image<glm::vec4> image(kSide, kSide);
  for (size_t i = 0; i < levels.size(); ++i) {
    const float linear = linearFromSrgb(static_cast<float>(levels[i]));
    image[i] = glm::vec4(glm::vec3(linear), 1.0f);
  }
  const ColorPlanes shown = srgbPlanes(image, kBlack, "a test");
  for (size_t i = 0; i < levels.size(); ++i) levels[i] = static_cast<long double>(shown[0][i]);
  return image;
}

TEST(Case56, SsimOfFlatAndNearlyFlatPicturesIsTheTruth) {
  std::mt19937 random(56);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  long double worst = 0.0L, worstOfAlike = 0.0L;
  for (int round = 0; round < 300; ++round) {
    const double level = 0.5 + 0.5 * unit(random), other = round % 3 == 0 ? level : 0.5 + 0.5 * unit(random);
    const double noise = round % 2 == 0 ? 0.0 : std::pow(10.0, -6.0 + 5.0 * std::abs(unit(random)));
    Levels a(kSide * kSide), b(kSide * kSide);
    for (size_t i = 0; i < a.size(); ++i) {
      const double common = noise * unit(random);
      a[i] = std::clamp(level + common, 0.0, 1.0);
      b[i] = std::clamp(other + (round % 5 == 0 ? -1.0 : 1.0) * common + (round % 4 == 0 ? 0.0 : 0.3 * noise * unit(random)), 0.0, 1.0);
    }
    const Image<glm::vec4> imageA = pictureOf(a), imageB = pictureOf(b);
    const double ssim = ssimSrgb(imageA, imageB, kBlack);
    ASSERT_LE(ssim, 1.0) << "seed 56, round " << round;
    ASSERT_GE(ssim, -1.0) << "seed 56, round " << round;
    const long double error = std::abs(static_cast<long double>(ssim) - ssimTruth(a, b));
    worst = std::max(worst, error);
    if (std::abs(level - other) < 0.1) worstOfAlike = std::max(worstOfAlike, error);
    ASSERT_EQ(ssimSrgb(imageA, imageA, kBlack), 1.0) << "seed 56, round " << round;
  }
  EXPECT_LT(worst, 1.2e-4L);
  EXPECT_LT(worstOfAlike, 2e-5L);
}

}  // namespace
}  // namespace warpscope
