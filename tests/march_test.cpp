// The loop along one ray with made-up samples: which of them are reported, and what lights are told. Hard rays: stability/marching_test.cpp.
// Mirrors render/march/march.h and light.h.
#include "render/march/march.h"

#include <gtest/gtest.h>

#include <cmath>

#include "made_up_source.h"

namespace warpscope {
namespace {

TEST(MarchRay, EverySampleThatCountsIsReportedAndNoOther) {
  const Marched result = march(latticeOf(0.0f, 6.0f, 1.0f), [](int i) {
    return std::array{kContribution, std::nextafter(kContribution, 0.0f), 0.5f, 0.5f * kContribution, 2.1f * kContribution, 0.0f}[i];
  });
  ASSERT_EQ(result.counting.size(), 3u);
  EXPECT_EQ(result.counting[0].t, 0.5f);
  EXPECT_EQ(result.counting[1].t, 2.5f);
  EXPECT_EQ(result.counting[2].t, 4.5f);
}

// --- Light: policies of this test alone, without a line of the march changed.

/// Whatever the class, the opacity in red.
struct Red {
  template <class Source>
  glm::vec3 shade(const ClassifiedSample& sample, const Ray&, const Source&, int) const {
    return {sample.alpha, 0.0f, 0.0f};
  }
};

/// Dims with the depth of the place, seen from a side; asks the source for what it looked at.
struct DimsWithDepth {
  float depth = 1.0f;  // at which nothing is left

  template <class Source>
  glm::vec3 shade(const ClassifiedSample& sample, const Ray& ray, const Source& source, int k) const {
    EXPECT_EQ(source.first + k, sample.i);
    EXPECT_EQ(glm::length(ray.direction), 1.0f);
    return sample.color * (1.0f - ray.at(sample.t).z / depth);
  }
};

TEST(Light, ColoursAreTheLightsAndNothingElseChanges) {
  const auto profile = [](int i) { return i % 3 == 0 ? 0.0f : 0.125f + 0.01f * static_cast<float>(i % 7); };
  const RayLattice lattice = latticeOf(2.0f, 40.3f, 1.0f);
  const Marched unlit = march(lattice, profile, kContribution);
  const Marched red = march(lattice, profile, kContribution, {}, Red{});
  EXPECT_TRUE(sameSamples(unlit.counting, red.counting));
  EXPECT_EQ(red.color.transmittance.exact(), unlit.color.transmittance.exact());
  EXPECT_NEAR(red.color.premultiplied().r, red.color.premultiplied().a, 1e-6);
  EXPECT_EQ(red.color.premultiplied().g, 0.0f);
  EXPECT_EQ(red.color.premultiplied().b, 0.0f);
}

TEST(Light, KnowsPlaceStepAndSource) {
  // The last step is a part of one, and counts with what is left of its opacity.
  const RayLattice lattice = latticeOf(2.0f, 5.25f, 1.0f);
  const DimsWithDepth light{16.0f};
  double expected = 0.0, through = 1.0;
  for (int i = 0; i < lattice.count; ++i) {
    const double alpha = i + 1 < lattice.count ? 0.25 : -std::expm1(0.25 * std::log1p(-0.25));
    const double z = i + 1 < lattice.count ? 2.5 + i : 7.125;
    expected += through * alpha * (1.0 - z / 16.0);
    through *= 1.0 - alpha;
  }
  EXPECT_NEAR(march(
                  lattice, [](int) { return 0.25f; }, 0.0f, {}, light)
                  .color.color()
                  .r,
              expected, 1e-6);
  EXPECT_NEAR(march<1>(
                  lattice, [](int) { return 0.25f; }, 0.0f, {}, light)
                  .color.color()
                  .r,
              expected, 1e-6);
}

}  // namespace
}  // namespace warpscope
