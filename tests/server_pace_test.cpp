// Frames that take as long as they may: the rule against marches of known cost, in virtual time; when a camera moves; what is left out, and what is said.
// Mirrors app/frames/server_pace.h and app/frames/coarsening.h.
#include "app/frames/server_pace.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "app/frames/coarsening.h"

namespace warpscope {
namespace {

using std::chrono::milliseconds;

constexpr double kPixels = 512.0 * 512.0;
constexpr double kStep = 0.5;

/// Milliseconds of a march of kPixels: a part that no step changes, and one that all samples share.
struct Cost {
  double fixedMs = 0.0, ofStepOneMs = 50.0;
  double at(double step) const { return fixedMs + ofStepOneMs / step; }
};

/// Milliseconds of `frames` in a row. `noise`: factor on each.
template <class Noise>
std::vector<double> run(CoarseningRule& rule, const Cost& cost, double targetMs, int frames, const Noise& noise, std::vector<double>* factors = nullptr) {
  std::vector<double> took;
  for (int i = 0; i < frames; ++i) {
    const double factor = rule.factorFor(kPixels, kStep, targetMs);
    EXPECT_GE(factor, 1.0);
    EXPECT_LE(factor, kMostCoarsening);
    if (factors) factors->push_back(factor);
    took.push_back(cost.at(kStep * factor) * noise());
    rule.note(kPixels, kStep * factor, took.back());
  }
  return took;
}
double silence() { return 1.0; }

TEST(CoarseningRule, NothingIsLeftOutUntilSomethingIsKnown) {
  CoarseningRule rule;
  EXPECT_EQ(rule.factorFor(kPixels, kStep, 1.0), 1.0);
}

TEST(CoarseningRule, ConvergesToTheTargetFromOneSideAndStays) {
  for (const double targetMs : {40.0, 60.0})
    for (const double fixedMs : {0.0, 5.0, targetMs / 3.0, targetMs / 2.0}) {
      if (100.0 / (targetMs - fixedMs) > kMostCoarsening) continue;
      SCOPED_TRACE(std::to_string(fixedMs) + " of " + std::to_string(targetMs));
      CoarseningRule rule;
      std::vector<double> factors;
      const Cost cost{fixedMs, 50.0};
      const std::vector<double> took = run(rule, cost, targetMs, 60, silence, &factors);
      EXPECT_NEAR(took.back(), targetMs, 0.17 * targetMs);
      for (size_t i = 1; i < factors.size(); ++i) EXPECT_GE(factors[i], factors[i - 1]) << "an overshoot at " << i;
      for (size_t i = 31; i < factors.size(); ++i) EXPECT_EQ(factors[i], factors[30]) << i;
      EXPECT_NEAR(took[12], took.back(), 0.25 * targetMs) << "slow";
    }
}

TEST(CoarseningRule, WhatFitsIsNotCoarser) {
  CoarseningRule rule;
  std::vector<double> factors;
  run(rule, {0.0, 50.0}, 101.0, 20, silence, &factors);  // takes 100
  for (const double factor : factors) EXPECT_EQ(factor, 1.0);
}

TEST(CoarseningRule, WhatCannotFitEndsAtTheMost) {
  for (const double fixedMs : {0.0, 50.0}) {
    CoarseningRule rule;
    std::vector<double> factors;
    run(rule, {fixedMs, 50.0}, 10.0, 40, silence, &factors);
    EXPECT_EQ(factors.back(), kMostCoarsening);
    EXPECT_EQ(factors[factors.size() - 5], kMostCoarsening);
  }
}

TEST(CoarseningRule, FollowsALoadThatComesAndGoes) {
  CoarseningRule rule;
  EXPECT_NEAR(run(rule, {2.0, 50.0}, 50.0, 30, silence).back(), 50.0, 8.0);
  EXPECT_NEAR(run(rule, {6.0, 80.0}, 50.0, 30, silence).back(), 50.0, 8.0);
  EXPECT_NEAR(run(rule, {2.0, 50.0}, 50.0, 30, silence).back(), 50.0, 8.0);
  EXPECT_LE(run(rule, {1.0, 5.0}, 50.0, 30, silence).back(), 11.01) << "in full again: 1 + 5 / 0.5";
}

TEST(CoarseningRule, NoiseDoesNotMakeItSwing) {
  const uint32_t seed = std::random_device{}();
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> factor(0.9, 1.1);
  CoarseningRule rule;
  std::vector<double> factors;
  run(rule, {5.0, 50.0}, 50.0, 400, [&] { return factor(random); }, &factors);
  int changes = 0;
  for (size_t i = 40; i < factors.size(); ++i) {
    EXPECT_GT(factors[i], factors[40] / 1.35);
    EXPECT_LT(factors[i], factors[40] * 1.35);
    changes += factors[i] != factors[i - 1];
  }
  EXPECT_LT(changes, 40) << "of 360: pictures flicker";
}

TEST(CoarseningRule, OneSlowFrameIsHalfBelieved) {
  CoarseningRule rule;
  run(rule, {0.0, 50.0}, 50.0, 30, silence);
  const double before = rule.factorFor(kPixels, kStep, 50.0);
  rule.note(kPixels, kStep * before, 4.0 * 50.0);
  EXPECT_NEAR(rule.factorFor(kPixels, kStep, 50.0) / before, 2.0, 0.35);
}

TEST(CoarseningRule, PixelsAndStepsOfARequestAreHeeded) {
  CoarseningRule rule;
  rule.note(kPixels, 0.5, 100.0);
  EXPECT_NEAR(rule.factorFor(kPixels, 0.5, 50.0), 2.0, 1e-9);
  EXPECT_NEAR(rule.factorFor(2.0 * kPixels, 0.5, 50.0), 4.0, 1e-9);
  EXPECT_NEAR(rule.factorFor(2.0 * kPixels, 1.0, 50.0), 2.0, 1e-9);
  EXPECT_NEAR(rule.factorFor(kPixels, 1.0, 50.0), 1.0, 1e-9);
}

TEST(CoarseningRule, TimesThatAreNoneAreSurvived) {
  CoarseningRule rule;
  rule.note(kPixels, kStep, 0.0);
  EXPECT_EQ(rule.factorFor(kPixels, kStep, 1.0), 1.0);
  rule.note(0.0, kStep, 1e9);
  EXPECT_GE(rule.factorFor(kPixels, kStep, 1.0), 1.0);
  EXPECT_LE(rule.factorFor(kPixels, kStep, 1e-9), kMostCoarsening);
}

class ServerPaceTest : public testing::Test {
 protected:
  static Camera from(float x) {
    Camera camera;
    camera.eye.x = x;
    camera.width = camera.height = 512;
    return camera;
  }
  /// The step that is marched with when a request comes after so many milliseconds; the march takes 100 at step 0.5.
  float stepFor(float x, int afterMs) {
    now_ += milliseconds(afterMs);
    const MarchSettings marched = pace_.settingsFor(from(x), asked_, 50.0, now_);
    const double tookMs = 50.0 / marched.render.step;
    now_ += std::chrono::microseconds(static_cast<int64_t>(1e3 * tookMs));
    pace_.note(from(x), marched, tookMs, now_);
    return marched.render.step;
  }

  ServerPace pace_;
  MarchSettings asked_;
  Clock::TimePoint now_{std::chrono::hours(1)};
};

TEST_F(ServerPaceTest, ACameraThatMovesIsMarchedCoarserAndOneThatRestsInFull) {
  EXPECT_EQ(stepFor(1, 0), 0.5f) << "nobody knows yet whether it moves";
  EXPECT_FLOAT_EQ(stepFor(2, 5), 1.0f);
  EXPECT_FLOAT_EQ(stepFor(3, 5), 1.0f);
  EXPECT_EQ(stepFor(3, 150), 0.5f) << "asked for again";
  EXPECT_FLOAT_EQ(stepFor(4, 5), 1.0f);
  EXPECT_EQ(stepFor(5, 1001), 0.5f) << "after a rest";
  EXPECT_FLOAT_EQ(stepFor(6, 1000), 1.0f);
}

TEST_F(ServerPaceTest, AMarchThatTakesLongDoesNotLookLikeARest) {
  asked_.render.step = 0.01f;  // 5 s
  EXPECT_EQ(stepFor(1, 0), 0.01f);
  EXPECT_FLOAT_EQ(stepFor(2, 100), static_cast<float>(0.01 * kMostCoarsening));
}

TEST(Coarsening, TheStepGrowsAndStaysInItsRange) {
  MarchSettings asked;
  asked.sample.threshold = 0.3f;
  EXPECT_EQ(coarsened(asked, 1.0), asked);
  EXPECT_EQ(coarsened(asked, 0.1), asked);
  EXPECT_EQ(coarsened(asked, std::nan("")), asked);
  MarchSettings expected = asked;
  expected.render.step = 1.25f;
  EXPECT_EQ(coarsened(asked, 2.5), expected);
  EXPECT_EQ(coarsened(asked, 1e9).render.step, static_cast<float>(0.5 * kMostCoarsening));
  asked.render.step = 900.0f;
  EXPECT_EQ(coarsened(asked, 4.0).render.step, 1000.0f);
  EXPECT_NO_THROW(validate(coarsened(asked, 4.0)));
}

TEST(Coarsening, IsToldFromEverythingElse) {
  MarchSettings asked;
  EXPECT_FALSE(isCoarsened(asked, asked));
  for (const double factor : {1.0001, 1.5, 2.0, 3.7, 4.0, 50.0}) {
    const MarchSettings marched = coarsened(asked, factor);
    EXPECT_TRUE(isCoarsened(asked, marched)) << factor;
    EXPECT_NEAR(coarseningOf(asked, marched), std::min(factor, kMostCoarsening), 1e-6);
    EXPECT_FALSE(isCoarsened(marched, asked)) << "finer than asked for";
  }
  MarchSettings other = coarsened(asked, 2.0);
  other.sample.heuristic = Heuristic::exit;
  EXPECT_FALSE(isCoarsened(asked, other));
  other = coarsened(asked, 2.0);
  other.render.contribution *= 2.0f;
  EXPECT_FALSE(isCoarsened(asked, other));
  other = asked;
  other.render.step = asked.render.step * static_cast<float>(1.001 * kMostCoarsening);
  EXPECT_FALSE(isCoarsened(asked, other));
  other.render.step = std::nanf("");
  EXPECT_FALSE(isCoarsened(asked, other));
}

TEST(Coarsening, SaysWhatItLeavesOut) {
  const MarchSettings asked;
  EXPECT_EQ(coarseningText(asked, asked), "");
  EXPECT_EQ(coarseningText(asked, coarsened(asked, 2.4)), "step 1.2 instead of 0.5");
}

}  // namespace
}  // namespace warpscope
