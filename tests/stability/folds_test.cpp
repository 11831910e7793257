// Which depth stands for a ray where hardly any light is taken: cases 30, 34 and 35. Truth: closed forms.
// Mirrors render/march/depth_heuristic.h and transmittance.h.
#include <gtest/gtest.h>

#include <cmath>

#include "render/march/depth_heuristic.h"
#include "render/march/transmittance.h"

namespace warpscope {
namespace {

/// Depth of `count` samples of the same opacity, one unit apart, as a march folds them.
template <class Depth>
float depthOfHaze(float alpha, int count, float threshold) {
  ProfileFold profile;
  const auto fold = [&](auto&& add) {
    Transmittance transmittance;
    for (int i = 0; i < count; ++i) {
      add(CountingSample::behind(transmittance.exact(), static_cast<float>(i) + 0.5f, 1.0f, alpha));
      transmittance.pass(alpha);
    }
  };
  if constexpr (Depth::kTwoPass) fold([&](const CountingSample& sample) { profile.add(sample); });
  auto state = Depth::start(threshold, profile);
  fold([&](const CountingSample& sample) { state.add(sample); });
  return Depth::result(state).depth;
}

TEST(Case34, HalfOfAThinHazesOpacityIsReachedInItsMiddle) {
  for (const float alpha : {1e-6f, 3e-6f, 1e-5f, 1e-4f, 1e-3f, 1e-2f})
    for (const int count : {1, 2, 10, 100, 1000, 100000}) {
      const double all = -std::expm1(count * std::log1p(-static_cast<double>(alpha)));
      const auto depthWhere = [&](double opacity) { return std::log1p(-opacity) / std::log1p(-static_cast<double>(alpha)); };
      // Crossings are refined linearly inside the step, which is off by an eighth of its opacity at most, of the step.
      const double tolerance = 2e-7 * count + 0.13 * static_cast<double>(alpha) + 1e-6;
      EXPECT_NEAR(depthOfHaze<MedianDepth>(alpha, count, 0.0f), depthWhere(0.5 * all), tolerance) << alpha << ", " << count;
      EXPECT_NEAR(depthOfHaze<RelThresholdDepth>(alpha, count, 0.8f), depthWhere(0.8 * all), 2.0 * tolerance) << alpha << ", " << count;
    }
}

TEST(Case34, TransmittanceNeverStallsNorRises) {
  Transmittance transmittance;
  double before = transmittance.exact();
  for (int i = 0; i < 100000; ++i) {
    transmittance.pass(0.01f);
    ASSERT_GE(transmittance.exact(), 0.0);
    ASSERT_TRUE(transmittance.exact() < before || before < 1e-300) << i;
    before = transmittance.exact();
  }
}

TEST(Case30, AMillionStepsOfHardlyAnyOpacityAddUp) {
  Transmittance transmittance;
  for (int i = 0; i < 1000000; ++i) transmittance.pass(1e-8f);
  EXPECT_NEAR(transmittance.opacity(), 0.00995017, 1e-8);
}

}  // namespace
}  // namespace warpscope
