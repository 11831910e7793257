// The loop along one ray and its lattice, with made-up samples: faint, opaque and empty steps, very many of them, the last partial one.
// Mirrors render/march/march.h and lattice.h; closed forms in long double, counts in exact arithmetic.
#include "render/march/march.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <boost/multiprecision/cpp_bin_float.hpp>
#include <cmath>
#include <functional>
#include <random>

#include "made_up_source.h"

namespace warpscope {
namespace {

using Exact = boost::multiprecision::cpp_bin_float_100;

constexpr float kContribution = 1.0f / 1024;

struct Marched {
  RayColor color;
  std::vector<CountingSample> counting;
};

template <int kSize = 8, class Light = Unlit>
Marched march(const RayLattice& lattice, const std::function<float(int)>& alphaAt, float stopBelow = 0.0f,
              std::vector<int> cuts = {}, const Light& light = {}) {
  MadeUpSource<kSize> source{alphaAt, lattice};
  Marched result;
  cuts.push_back(lattice.count);
  int begin = 0;
  for (const int end : cuts) {
    if (result.color.transmittance.value() < stopBelow) break;
    marchRay(alongZ(lattice), begin, end, source, light, {kContribution, stopBelow}, result.color,
             [&](const CountingSample& sample) {
               result.counting.push_back(sample);
               return true;
             });
    begin = end;
  }
  return result;
}

bool sameSamples(const std::vector<CountingSample>& a, const std::vector<CountingSample>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const CountingSample& x, const CountingSample& y) {
    return x.t == y.t && x.ds == y.ds && x.alpha == y.alpha && x.transmittance == y.transmittance;
  });
}

DepthResult depthOf(Heuristic heuristic, const std::vector<CountingSample>& counting) {
  return visitHeuristic(heuristic, [&](auto depth) {
    using Depth = decltype(depth);
    ProfileFold ray;
    for (const CountingSample& sample : counting) ray.add(sample);
    auto fold = Depth::start(0.8f, ray);
    for (const CountingSample& sample : counting) fold.add(sample);
    return Depth::result(fold);
  });
}

TEST(MarchRay, AMillionNearlyTransparentSamplesAddUp) {
  const Marched result = march(latticeOf(0.0f, 1e6f, 1.0f), [](int) { return 1e-8f; });
  EXPECT_NEAR(result.color.premultiplied().a, 0.00995017, 1e-6);
  EXPECT_NEAR(result.color.color().r, 0.00995017, 1e-6);
  EXPECT_NEAR(result.color.color().b, 0.25 * 0.00995017, 1e-6);
}

TEST(MarchRay, AnOpaqueSampleEndsTheRayAndIsRecorded) {
  const auto profile = [](int i) { return i == 3 ? 1.0f : i > 3 ? 0.5f : 0.0f; };
  for (const float stopBelow : {0.0f, kContribution}) {
    const Marched result = march(latticeOf(2.0f, 10.0f, 1.0f), profile, stopBelow);
    EXPECT_EQ(result.color.premultiplied(), glm::vec4(1.0f, 0.5f, 0.25f, 1.0f));
    ASSERT_EQ(result.counting.size(), 1u);
    EXPECT_EQ(result.counting[0].t, 5.5f);
    EXPECT_EQ(result.counting[0].transmittance, 1.0f);
  }
}

TEST(MarchRay, HomogeneousSlabIsTheClosedFormAtEveryStep) {
  for (const float alpha : {0.001f, 0.05f, 0.4f, 0.99f})
    for (const float length : {10.0f, 9.73f, 0.3f, 100.0f})
      for (const float dt : {1.0f, 0.5f, 0.25f, 0.1f, 0.01f}) {
        const float perStep = correctOpacity(alpha, dt);
        const Marched result = march(latticeOf(0.0f, length, dt), [&](int) { return perStep; });
        const long double truth = -std::expm1(static_cast<long double>(length) * std::log1p(-static_cast<long double>(alpha)));
        EXPECT_NEAR(result.color.premultiplied().a, static_cast<double>(truth), 1e-6) << alpha << " " << length << " " << dt;
        EXPECT_NEAR(result.color.color().g, 0.5 * static_cast<double>(truth), 1e-6) << alpha << " " << length << " " << dt;
      }
}

TEST(MarchRay, ThePartialLastStepIsCorrected) {
  // One step and a quarter of one.
  const Marched result = march(latticeOf(0.0f, 1.25f, 1.0f), [](int) { return 0.5f; });
  ASSERT_EQ(result.counting.size(), 2u);
  EXPECT_EQ(result.counting[1].ds, 0.25f);
  EXPECT_EQ(result.counting[1].t, 1.125f);
  EXPECT_NEAR(result.counting[1].alpha, 1.0 - std::pow(0.5, 0.25), 1e-7);
  EXPECT_NEAR(result.color.premultiplied().a, 1.0 - std::pow(0.5, 1.25), 1e-7);
}

TEST(MarchRay, TransmittanceFallsWithoutStallingAndNeverBelowZero) {
  Transmittance transmittance;
  double exact = 0.0;
  float before = 2.0f;
  for (int i = 0; i < 100000; ++i) {
    const float value = transmittance.value();
    ASSERT_GE(value, 0.0f);
    ASSERT_LE(value, before);
    if (value > 1e-37f) {
      ASSERT_LT(value, before) << "stalls at sample " << i;
      ASSERT_NEAR(value / std::exp(exact), 1.0, 1e-6);
    }
    before = value;
    exact += std::log1p(-static_cast<double>(0.01f));
    transmittance.pass(0.01f);
  }
  EXPECT_EQ(transmittance.opacity(), 1.0f);
  EXPECT_EQ(march(latticeOf(0.0f, 1e5f, 1.0f), [](int) { return 0.01f; }).color.premultiplied().a, 1.0f);
}

RC_GTEST_PROP(MarchRay, StoppingEarlyChangesNoDepthAndHardlyAColour, (uint32_t seed)) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> unit(0.0f, 1.0f);
  for (int round = 0; round < 10; ++round) {
    const int count = 1 + static_cast<int>(random() % 300);
    const float scale = std::exp2(-8.0f * unit(random));
    std::vector<float> alphas(static_cast<size_t>(count));
    for (float& alpha : alphas) alpha = random() % 3 ? std::min(1.0f, 2.0f * scale * unit(random)) : 0.0f;
    const auto profile = [&](int i) { return alphas[static_cast<size_t>(i)]; };
    const RayLattice lattice = latticeOf(1.0f, 0.5f * static_cast<float>(count) - 0.2f, 0.5f);
    const Marched all = march(lattice, profile), some = march(lattice, profile, kContribution);
    RC_ASSERT(sameSamples(all.counting, some.counting));
    for (const auto& entry : kHeuristics) {
      const DepthResult a = depthOf(entry.value, all.counting), b = depthOf(entry.value, some.counting);
      RC_ASSERT(a.hasDepth == b.hasDepth);
      RC_ASSERT(a.depth == b.depth);
    }
    for (int c = 0; c < 4; ++c)
      RC_ASSERT(std::abs(all.color.premultiplied()[c] - some.color.premultiplied()[c]) <= kContribution);

    // In segments, and in batches of another size: the same bits.
    std::vector<int> cuts;
    for (int i = 0; i < 6; ++i) cuts.push_back(static_cast<int>(random() % (static_cast<uint32_t>(lattice.count) + 1)));
    std::sort(cuts.begin(), cuts.end());
    for (const Marched& other : {march(lattice, profile, 0.0f, cuts), march<1>(lattice, profile), march<32>(lattice, profile)}) {
      RC_ASSERT(sameSamples(all.counting, other.counting));
      RC_ASSERT(all.color.premultiplied() == other.color.premultiplied());
    }
  }
}

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

TEST(Light, TodaysIsTheTransferFunctionsColour) {
  visitLight(RenderSettings{}, [](auto light) { EXPECT_TRUE((std::is_same_v<decltype(light), Unlit>)); });
  EXPECT_TRUE(std::is_empty_v<Unlit>);
}

// --- The lattice.

/// How many steps of dt cover the length, exactly.
int64_t exactCount(float length, float dt) { return static_cast<int64_t>(ceil(Exact(length) / Exact(dt))); }

void checkLattice(float t0, float length, float dt) {
  const RayLattice lattice = makeLattice({t0, t0 + length}, dt);
  const float inside = (t0 + length) - t0;  // what is left of it in float
  ASSERT_EQ(lattice.count, exactCount(inside, dt)) << t0 << " " << length << " " << dt;
  ASSERT_EQ(lattice.length, inside);
  if (lattice.count == 0) return;
  const float last = lattice.stepLength(lattice.count - 1);
  const Exact exactLast = Exact(inside) - Exact(dt) * (lattice.count - 1);
  ASSERT_GE(last, 0.0f) << t0 << " " << length << " " << dt;
  ASSERT_NEAR(last, static_cast<double>(exactLast), 1e-7 * inside);
  for (const int i : {0, lattice.count / 2, lattice.count - 2, lattice.count - 1}) {
    if (i < 0) continue;
    if (i + 1 < lattice.count) {
      ASSERT_EQ(lattice.stepLength(i), dt);
    }
    const Exact middle = Exact(t0) + Exact(dt) * i + Exact(i + 1 < lattice.count ? Exact(dt) : exactLast) / 2;
    ASSERT_NEAR(lattice.t(i), static_cast<double>(middle), 3e-7 * (t0 + inside)) << i << " of " << lattice.count;
    ASSERT_GE(lattice.t(i), t0);
    ASSERT_LE(lattice.t(i), t0 + inside);
  }
}

TEST(RayLattice, CountsExactlyFarFromTheEyeWithTinySteps) {
  checkLattice(1e4f, 1.0f, 1e-4f);
  checkLattice(1e4f, 100.0f, 1e-4f);
  EXPECT_EQ(makeLattice({1e4f, 1e4f + 1.0f}, 1e-4f).count, exactCount(1.0f, 1e-4f));
  int samples = 0;
  const RayLattice lattice = latticeOf(1e4f, 1.0f, 1e-4f);
  MadeUpSource<8> source{[&](int) { return ++samples, 0.0f; }, lattice};
  RayColor color;
  marchRay(alongZ(lattice), 0, lattice.count, source, Unlit{}, {kContribution, 0.0f}, color,
           [](const CountingSample&) { return true; });
  EXPECT_EQ(samples, lattice.count);  // it ends, and looks at each once
}

TEST(RayLattice, WholeStepsLeaveNoEmptyOneBehind) {
  for (const float dt : {0.5f, 0.25f, 1.0f, 3.0f})
    for (const int steps : {1, 2, 3, 7, 1000, 65536}) {
      const RayLattice lattice = latticeOf(0.0f, static_cast<float>(steps) * dt, dt);
      EXPECT_EQ(lattice.count, steps);
      EXPECT_EQ(lattice.stepLength(steps - 1), dt);
    }
}

RC_GTEST_PROP(RayLattice, CoversTheRayOnceAtAnyMagnitude, (uint32_t seed)) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> unit(0.0f, 1.0f);
  for (int i = 0; i < 50; ++i) {
    const float dt = std::exp2(-10.0f + 12.0f * unit(random));
    const float length = dt * std::exp2(-3.0f + 18.0f * unit(random));
    const float t0 = random() % 2 ? 0.0f : length * std::exp2(10.0f * unit(random) - 5.0f);
    checkLattice(t0, length, dt);
    checkLattice(t0, std::floor(length / dt) * dt, dt);
    RC_ASSERT(!testing::Test::HasFailure());
  }
}

TEST(RayLattice, MoreSamplesThanFloatsCanCount) {
  // 2^24 and more: the last step must not get a negative length, or opacity grows out of nothing.
  for (const float length : {16777.3f, 40000.0f, 65535.9f, 113000.5f}) {
    const RayLattice lattice = latticeOf(0.0f, length, 1e-3f);
    ASSERT_GT(lattice.count, 1 << 24);
    for (int back = 1; back < 6; ++back) {
      EXPECT_GE(lattice.stepLength(lattice.count - back), 0.0f) << length;
      EXPECT_LE(lattice.stepLength(lattice.count - back), 1e-3f) << length;
      EXPECT_LE(lattice.t(lattice.count - back), length * (1.0f + 1e-7f)) << length;
    }
    EXPECT_GE(lattice.t(lattice.count - 1), lattice.t(lattice.count - 2)) << length;
  }
}

TEST(RayLattice, MissesAndPointsHaveNoSamples) {
  EXPECT_EQ(makeLattice(RayInterval{}, 1.0f).count, 0);
  EXPECT_EQ(makeLattice({5.0f, 5.0f}, 1.0f).count, 0);
  EXPECT_EQ(makeLattice({5.0f, 4.0f}, 1.0f).count, 0);
  EXPECT_EQ(makeLattice({0.0f, std::nanf("")}, 1.0f).count, 0);
}

}  // namespace
}  // namespace warpscope
