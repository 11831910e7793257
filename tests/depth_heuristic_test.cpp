// Depth heuristics: ties, single samples, none, and how crossings get better with the step. Their definitions: stability/folds_test.cpp.
// Mirrors render/march/depth_heuristic.h.
#include "render/march/depth_heuristic.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "render/march/transmittance.h"

namespace warpscope {
namespace {

using Samples = std::vector<CountingSample>;

/// The samples of a ray that count, with transmittance as marching tracks it.
Samples countingSamples(const std::vector<float>& alphas, float t0, float dt, float contribution) {
  Samples counting;
  Transmittance transmittance;
  for (size_t i = 0; i < alphas.size(); ++i) {
    const auto sample = CountingSample::behind(transmittance.exact(), t0 + (static_cast<float>(i) + 0.5f) * dt, dt, alphas[i]);
    if (sample.alpha > 0.0f && sample.contribution() >= contribution) counting.push_back(sample);
    transmittance.pass(alphas[i]);
  }
  return counting;
}

/// Depth by the product's folds, the ray cut before the given samples. Empty segments stay default-constructed.
DepthResult foldedDepth(Heuristic heuristic, const Samples& samples, float threshold, std::vector<size_t> cuts = {}) {
  cuts.insert(cuts.begin(), 0);
  cuts.push_back(samples.size());
  return visitHeuristic(heuristic, [&](auto depth) {
    using Depth = decltype(depth);
    ProfileFold ray;
    for (size_t s = 0; s + 1 < cuts.size(); ++s) {
      ProfileFold segment;
      for (size_t i = cuts[s]; i < cuts[s + 1]; ++i) segment.add(samples[i]);
      ray = ProfileFold::combine(ray, segment);
    }
    typename Depth::Fold whole{};
    for (size_t s = 0; s + 1 < cuts.size(); ++s) {
      typename Depth::Fold segment{};
      if (cuts[s] < cuts[s + 1]) segment = Depth::start(threshold, ray);
      for (size_t i = cuts[s]; i < cuts[s + 1]; ++i) segment.add(samples[i]);
      whole = Depth::Fold::combine(whole, segment);
    }
    return Depth::result(whole);
  });
}

TEST(DepthHeuristic, TiesGoToTheNearer) {
  // Opacities 0.2, 0.5, 0.5; then contributions 1/4, 1/4 (= 1/3 of 3/4, in floats that are exact: 0.5 * 0.5).
  EXPECT_EQ(foldedDepth(Heuristic::peak, countingSamples({0.25f, 0.5f, 0.5f}, 0, 1, 1e-3f), 0.8f).depth, 1.5f);
  EXPECT_EQ(foldedDepth(Heuristic::gradient, countingSamples({0.5f, 0.0f, 1.0f}, 0, 1, 1e-3f), 0.8f).depth, 0.5f);
  // In whichever segment the nearer one lies.
  EXPECT_EQ(foldedDepth(Heuristic::peak, countingSamples({0.25f, 0.5f, 0.5f}, 0, 1, 1e-3f), 0.8f, {2}).depth, 1.5f);
  EXPECT_EQ(foldedDepth(Heuristic::gradient, countingSamples({0.5f, 0.0f, 1.0f}, 0, 1, 1e-3f), 0.8f, {1}).depth, 0.5f);
}

TEST(DepthHeuristic, ACrossingThatIsMetExactlyEndsInItsStep) {
  const Samples samples = countingSamples({0.5f, 0.5f}, 0.0f, 1.0f, 1e-3f);
  EXPECT_EQ(foldedDepth(Heuristic::threshold, samples, 0.5f).depth, 1.0f);
  EXPECT_EQ(foldedDepth(Heuristic::threshold, samples, 0.625f).depth, 1.5f);
  EXPECT_EQ(foldedDepth(Heuristic::threshold, samples, 0.75f).depth, 2.0f);
  EXPECT_EQ(foldedDepth(Heuristic::threshold, samples, 0.76f).depth, 1.5f);  // never: exit
}

TEST(DepthHeuristic, WhatDoesNotCountMayCarryTheCrossing) {
  // A thousand faint samples pass the threshold; the next one that counts is where that shows, at its near end.
  std::vector<float> alphas(1001, 0.0009f);
  alphas.back() = 0.5f;
  const Samples samples = countingSamples(alphas, 0.0f, 1.0f, 1.0f / 1024);
  ASSERT_EQ(samples.size(), 1u);
  EXPECT_FLOAT_EQ(foldedDepth(Heuristic::threshold, samples, 0.3f).depth, 1000.0f);
}

/// What is chosen when it is used against what is chosen when it is compiled.
TEST(DepthHeuristic, OneTypeForAnyGivesWhatEachOneGives) {
  const auto depthOf = [](const auto& depth, const Samples& samples) {
    ProfileFold ray;
    for (const CountingSample& sample : samples) ray.add(sample);
    auto fold = depth.start(0.4f, ray);
    for (const CountingSample& sample : samples) fold.add(sample);
    return depth.result(fold);
  };
  int found = 0;
  for (const std::vector<float>& alphas : {std::vector<float>{}, {0.0f}, {0.3f}, {0.1f, 0.4f, 0.2f, 0.4f, 0.05f}, {0.01f, 0.02f, 0.9f, 1.0f}})
    for (const auto& named : kHeuristics) {
      const Heuristic heuristic = named.value;
      const Samples samples = countingSamples(alphas, 2.0f, 0.5f, 1e-3f);
      const DepthResult one = visitHeuristic(heuristic, [&](auto depth) { return depthOf(depth, samples); });
      const DepthResult any = visitAnyHeuristic(heuristic, [&](auto depth) { return depthOf(depth, samples); });
      EXPECT_EQ(one.hasDepth, any.hasDepth) << named.name;
      EXPECT_EQ(one.depth, any.depth) << named.name;
      found += one.hasDepth;
    }
  EXPECT_EQ(found, 30);
}

// --- What older implementations lost.

TEST(DepthHeuristic, ASingleSampleIsFoundInItsOwnStep) {
  for (const float alpha : {1.0f / 1024, 0.1f, 0.9f, 1.0f})
    for (const auto& entry : kHeuristics) {
      std::vector<float> alphas(9, 0.0f);
      alphas[4] = alpha;
      const DepthResult result = foldedDepth(entry.value, countingSamples(alphas, 10.0f, 0.25f, 1.0f / 1024), 0.8f);
      ASSERT_TRUE(result.hasDepth) << entry.name;
      EXPECT_GE(result.depth, 11.0f) << entry.name;  // not one step too far
      EXPECT_LE(result.depth, 11.25f) << entry.name;
    }
}

TEST(DepthHeuristic, DepthZeroIsADepth) {
  for (const auto& entry : kHeuristics) {
    const DepthResult result = foldedDepth(entry.value, {{0.0f, 0.0f, 0.5f, 1.0f}}, 0.8f);
    EXPECT_TRUE(result.hasDepth) << entry.name;
    EXPECT_EQ(result.depth, 0.0f) << entry.name;
  }
}

TEST(DepthHeuristic, NothingThatCountsIsAMiss) {
  for (const auto& entry : kHeuristics) {
    EXPECT_FALSE(foldedDepth(entry.value, {}, 0.8f).hasDepth) << entry.name;
    EXPECT_FALSE(foldedDepth(entry.value, {}, 0.8f, {0, 0, 0}).hasDepth) << entry.name;
  }
}

// --- Refinement: density k * t, so that A(t) = 1 - exp(-k t^2 / 2), and A = a lies at sqrt(-2 ln(1 - a) / k).

double errorOf(Heuristic heuristic, double dt, double k, double length) {
  const auto count = static_cast<size_t>(std::lround(length / dt));
  std::vector<float> alphas;
  for (size_t i = 0; i < count; ++i) alphas.push_back(static_cast<float>(-std::expm1(-k * (static_cast<double>(i) + 0.5) * dt * dt)));
  const double end = -std::expm1(-0.5 * k * length * length);
  double tau = 0.8;
  if (heuristic == Heuristic::relThreshold) tau = 0.8 * end;
  if (heuristic == Heuristic::median) tau = 0.5 * end;
  if (heuristic == Heuristic::enExMean) tau = -0.5 * (std::expm1(-k * 0.5 * dt * dt) + std::expm1(-k * (length - 0.5 * dt) * dt));
  const double truth = std::sqrt(-2.0 * std::log1p(-tau) / k);
  const Samples samples = countingSamples(alphas, 0.0f, static_cast<float>(dt), 0.0f);
  return std::abs(foldedDepth(heuristic, samples, 0.8f).depth - truth);
}

/// Over many places of the crossing within its step, or chance would decide.
double worstError(Heuristic heuristic, double dt) {
  double worst = 0.0;
  // en-ex-mean lies near the entrance, where a thin medium is needed for the profile to be curved at every step length alike.
  const double thinnest = heuristic == Heuristic::enExMean ? 0.02 : 0.14;
  for (double k = thinnest; k < thinnest + 0.1; k += 0.005)
    for (double length = 5.0; length <= 9.0; length += 0.5) worst = std::max(worst, errorOf(heuristic, dt, k, length));
  return worst;
}

TEST(DepthHeuristic, HalvingTheStepHalvesTheErrorOrBetter) {
  for (const Heuristic heuristic : {Heuristic::threshold, Heuristic::relThreshold, Heuristic::median, Heuristic::enExMean}) {
    double before = worstError(heuristic, 0.5);
    EXPECT_LT(before, 0.25) << nameOf(heuristic);
    for (const double dt : {0.25, 0.125, 0.0625, 0.03125}) {
      const double error = worstError(heuristic, dt);
      EXPECT_LE(error, 0.5 * before) << nameOf(heuristic) << " at " << dt;
      before = error;
    }
  }
}

}  // namespace
}  // namespace warpscope
