// Every depth heuristic against a naive implementation of the table of definitions, in long double; and as a fold, cut anywhere.
// Mirrors render/march/depth_heuristic.h; definitions after Zellmann, Aumueller, Lang 2012.
#include "render/march/depth_heuristic.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
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

// --- The naive implementation. A sample as the table writes it: t_i, ds, alpha_i, T_i, w_i, A_i.

struct Row {
  long double t, ds, alpha, transmittance, w, after;
};

std::vector<Row> rowsOf(const std::vector<float>& alphas, float t0, float dt, float contribution, bool& undecided) {
  std::vector<Row> rows;
  long double transmittance = 1.0L;
  for (size_t i = 0; i < alphas.size(); ++i) {
    const long double alpha = alphas[i], w = alpha * transmittance;
    if (std::abs(w - contribution) < 1e-6L * contribution) undecided = true;
    if (w >= contribution)
      rows.push_back({t0 + (i + 0.5L) * dt, dt, alpha, transmittance, w, 1.0L - transmittance * (1.0L - alpha)});
    transmittance *= 1.0L - alpha;
  }
  return rows;
}

long double naiveCrossing(const std::vector<Row>& rows, long double tau) {
  for (const Row& row : rows) {
    if (row.after < tau) continue;
    const long double before = 1.0L - row.transmittance;
    const long double fraction = std::clamp((tau - before) / (row.after - before), 0.0L, 1.0L);
    return row.t + (fraction - 0.5L) * row.ds;
  }
  return rows.back().t;
}

/// Lowest and highest answer that rounding can excuse.
struct Answer {
  long double lowest, highest, spread = 0.0L;
};

Answer naiveDepth(Heuristic heuristic, const std::vector<Row>& rows, long double threshold) {
  const auto exactly = [](long double t) { return Answer{t, t}; };
  const auto crossing = [&](long double tau) {
    const long double rounding = 2.5e-7L * tau + 1e-15L;  // of 1 - T in float, T in double
    const long double low = naiveCrossing(rows, tau - rounding), high = naiveCrossing(rows, tau + rounding);
    const Row& last = rows.back();
    if (std::abs(tau - last.after) <= rounding)  // crossed at the last step's end, or never: then its middle
      return Answer{std::min(low, last.t), std::max(high, last.t + 0.5L * last.ds)};
    return Answer{low, high};
  };
  const auto largest = [&](auto key) {
    long double best = 0.0L;
    for (const Row& row : rows) best = std::max(best, key(row));
    Answer answer{1e30L, -1e30L};
    for (const Row& row : rows)
      if (key(row) >= best * (1.0L - 4e-7L)) answer = {std::min(answer.lowest, row.t), std::max(answer.highest, row.t)};
    return answer;
  };
  const long double end = rows.back().after;
  switch (heuristic) {
    case Heuristic::entrance: return exactly(rows.front().t);
    case Heuristic::exit: return exactly(rows.back().t);
    case Heuristic::midpoint: return exactly((rows.front().t + rows.back().t) / 2.0L);
    case Heuristic::threshold: return crossing(threshold);
    case Heuristic::peak:
      for (const Row& row : rows)
        if (std::all_of(rows.begin(), rows.end(), [&](const Row& other) { return other.alpha <= row.alpha; })) return exactly(row.t);
      break;
    case Heuristic::gradient: return largest([](const Row& row) { return row.w; });
    case Heuristic::relThreshold: return crossing(threshold * end);
    case Heuristic::enExMean: return crossing((rows.front().alpha + rows.back().alpha) / 2.0L);
    case Heuristic::median: return crossing(end / 2.0L);
    case Heuristic::expected: break;
  }
  long double weight = 0.0L, sum = 0.0L, squares = 0.0L;
  for (const Row& row : rows) weight += row.w, sum += row.w * row.t;
  for (const Row& row : rows) squares += row.w * (row.t - sum / weight) * (row.t - sum / weight);
  return {sum / weight, sum / weight, std::sqrt(squares / weight)};
}

std::vector<float> randomProfile(std::mt19937& random) {
  std::uniform_real_distribution<float> unit(0.0f, 1.0f);
  const size_t count = 1 + random() % 200;
  const float scale = std::exp2(-12.0f * unit(random));
  std::vector<float> alphas(count);
  for (float& alpha : alphas) {
    const uint32_t kind = random() % 8;
    alpha = kind < 3 ? 0.0f : std::min(1.0f, 2.0f * scale * unit(random));
    if (kind == 7) alpha = scale;  // repeated values: ties
  }
  if (random() % 4 == 0) alphas[random() % count] = 1.0f;
  return alphas;
}

RC_GTEST_PROP(DepthHeuristic, AgreesWithTheDefinitions, (uint32_t seed)) {
  std::mt19937 random(seed);
  for (int round = 0; round < 10; ++round) {
    const std::vector<float> alphas = randomProfile(random);
    const float t0 = static_cast<float>(random() % 1000) * 0.37f, dt = std::exp2(static_cast<float>(random() % 8) - 5.0f);
    const float contribution = 1.0f / 1024, threshold = random() % 2 ? 0.8f : 0.3f;
    bool undecided = false;
    const std::vector<Row> rows = rowsOf(alphas, t0, dt, contribution, undecided);
    if (undecided) continue;
    const Samples samples = countingSamples(alphas, t0, dt, contribution);
    RC_ASSERT(samples.size() == rows.size());
    const long double rounding = 1e-6L * (t0 + dt * alphas.size());
    for (const auto& entry : kHeuristics) {
      const DepthResult result = foldedDepth(entry.value, samples, threshold);
      RC_ASSERT(result.hasDepth == !rows.empty());
      if (rows.empty()) continue;
      const Answer truth = naiveDepth(entry.value, rows, threshold);
      RC_LOG() << entry.name << ": " << result.depth << " in " << double(truth.lowest) << " .. " << double(truth.highest) << '\n';
      RC_ASSERT(result.depth >= truth.lowest - rounding);
      RC_ASSERT(result.depth <= truth.highest + rounding);
      RC_ASSERT(std::abs(result.spread - truth.spread) <= 1e-4L * truth.spread + 2.0L * rounding);
    }
  }
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

// --- Folds.

RC_GTEST_PROP(DepthHeuristic, TheSameDepthInOneTwoOrSevenSegments, (uint32_t seed)) {
  std::mt19937 random(seed);
  for (int round = 0; round < 10; ++round) {
    const Samples samples = countingSamples(randomProfile(random), 3.0f, 0.5f, 1.0f / 1024);
    for (const size_t pieces : {size_t{2}, size_t{7}}) {
      std::vector<size_t> cuts;
      for (size_t i = 0; i + 1 < pieces; ++i) cuts.push_back(random() % (samples.size() + 1));
      std::sort(cuts.begin(), cuts.end());
      for (const auto& entry : kHeuristics) {
        const DepthResult whole = foldedDepth(entry.value, samples, 0.8f);
        const DepthResult cut = foldedDepth(entry.value, samples, 0.8f, cuts);
        RC_LOG() << entry.name << ": " << whole.depth << " " << cut.depth << '\n';
        RC_ASSERT(cut.hasDepth == whole.hasDepth);
        if (entry.value != Heuristic::expected) {
          RC_ASSERT(cut.depth == whole.depth);
          continue;
        }
        RC_ASSERT(std::abs(cut.depth - whole.depth) <= 1e-5f * std::max(1.0f, whole.depth));
        RC_ASSERT(std::abs(cut.spread - whole.spread) <= 1e-4f * std::max(1.0f, whole.depth));
      }
    }
  }
}

RC_GTEST_PROP(DepthHeuristic, CombiningIsAssociativeAndHasAnIdentity, (uint32_t seed)) {
  std::mt19937 random(seed);
  const Samples samples = countingSamples(randomProfile(random), 3.0f, 0.5f, 1.0f / 1024);
  const size_t first = random() % (samples.size() + 1);
  const size_t second = first + random() % (samples.size() - first + 1);
  for (const auto& entry : kHeuristics)
    visitHeuristic(entry.value, [&](auto depth) {
      using Depth = decltype(depth);
      using Fold = typename Depth::Fold;
      ProfileFold ray;
      for (const CountingSample& sample : samples) ray.add(sample);
      const auto segment = [&](size_t begin, size_t end) {
        Fold fold = Depth::start(0.8f, ray);
        for (size_t i = begin; i < end; ++i) fold.add(samples[i]);
        return fold;
      };
      const auto same = [&](const Fold& a, const Fold& b) {
        const DepthResult x = Depth::result(a), y = Depth::result(b);
        RC_ASSERT(x.hasDepth == y.hasDepth);
        if (x.hasDepth) RC_ASSERT(std::abs(x.depth - y.depth) <= 1e-5f * std::max(1.0f, x.depth));
        RC_ASSERT(std::abs(x.spread - y.spread) <= 1e-4f * std::max(1.0f, x.depth));
      };
      const Fold a = segment(0, first), b = segment(first, second), c = segment(second, samples.size());
      same(Fold::combine(Fold::combine(a, b), c), Fold::combine(a, Fold::combine(b, c)));
      // The identity, on either side; and what comes out can be gone on with.
      for (Fold fold : {Fold::combine({}, a), Fold::combine(a, {})}) {
        same(fold, a);
        for (size_t i = first; i < samples.size(); ++i) fold.add(samples[i]);
        same(fold, segment(0, samples.size()));
      }
    });
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
