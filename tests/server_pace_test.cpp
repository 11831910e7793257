// Frames that take as long as they may: the rule against marches of known cost, in virtual time; when a camera moves; what is left out, and what is said.
// Mirrors app/frames/server_pace.h and app/frames/coarsening.h.
#include "app/frames/server_pace.h"

#include <gtest/gtest.h>

#include <algorithm>
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
  std::mt19937 random(1);
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

/// What marches take by how many groups of effects are left out; the settings have two.
struct CostOfGroups {
  std::vector<Cost> costs;
  double at(double step, int leftOut) const { return costs[static_cast<size_t>(leftOut)].at(step); }
};

MarchSettings shadowed() {
  MarchSettings asked;
  asked.render.effects.shading.strength = 1.0f;
  asked.render.effects.shadows.strength = 0.5f;
  return asked;
}

/// A motion of so many frames after a rest, in which one frame is marched in full.
std::vector<Coarsening> move(LeavingOutRule& rule, const CostOfGroups& cost, double targetMs, int frames, std::vector<double>* took = nullptr) {
  const MarchSettings asked = shadowed();
  rule.noteAtRest(kPixels, asked, cost.at(kStep, 0));
  std::vector<Coarsening> chosen;
  for (int i = 0; i < frames; ++i) {
    chosen.push_back(rule.choose(kPixels, asked, targetMs));
    const double ms = cost.at(kStep * chosen.back().factor, chosen.back().leftOut);
    rule.noteMoving(kPixels, asked, chosen.back(), ms);
    if (took) took->push_back(ms);
  }
  return chosen;
}

TEST(LeavingOutRule, NothingGoesWhereTheStepIsEnough) {
  LeavingOutRule rule;
  for (int motion = 0; motion < 10; ++motion)
    for (const Coarsening& coarsening : move(rule, CostOfGroups{{{10.0, 50.0}, {5.0, 20.0}, {5.0, 10.0}}}, 50.0, 30)) EXPECT_EQ(coarsening.leftOut, 0);
}

TEST(LeavingOutRule, WhatStepsCannotDoLeavingOutDoes) {
  // In full 300 ms, of which steps can save 75; without the first group 100, of which they can save 75.
  const CostOfGroups cost{{{200.0, 50.0}, {25.0, 37.5}, {10.0, 20.0}}};
  LeavingOutRule rule;
  std::vector<double> took;
  const std::vector<Coarsening> chosen = move(rule, cost, 60.0, 40, &took);
  EXPECT_EQ(chosen.front().leftOut, 0) << "not before it is known";
  EXPECT_EQ(chosen.back().leftOut, 1) << "no more than is needed";
  for (size_t i = 1; i < chosen.size(); ++i) EXPECT_GE(chosen[i].leftOut, chosen[i - 1].leftOut) << "to and fro, at " << i;
  EXPECT_EQ(chosen[3].leftOut, 1) << "slow";
  EXPECT_NEAR(took.back(), 60.0, 0.17 * 60.0);
  EXPECT_LT(chosen.back().factor, kMostCoarsening) << "steps need not be as coarse any more";
}

TEST(LeavingOutRule, AllGoesWhereNothingIsEnough) {
  const CostOfGroups cost{{{200.0, 50.0}, {150.0, 40.0}, {100.0, 30.0}}};
  LeavingOutRule rule;
  const std::vector<Coarsening> chosen = move(rule, cost, 20.0, 20);
  EXPECT_EQ(chosen.back(), (Coarsening{kMostCoarsening, 2}));
}

TEST(LeavingOutRule, MotionsAfterOneAnotherSeldomTryAgain) {
  const CostOfGroups cost{{{200.0, 50.0}, {25.0, 37.5}, {10.0, 20.0}}};
  LeavingOutRule rule;
  move(rule, cost, 60.0, 20);
  int slow = 0;
  constexpr int kMotions = 40;
  for (int motion = 0; motion < kMotions; ++motion) {
    const std::vector<Coarsening> chosen = move(rule, cost, 60.0, 20);
    for (size_t i = 1; i < chosen.size(); ++i) EXPECT_GE(chosen[i].leftOut, chosen[i - 1].leftOut);
    slow += static_cast<int>(std::count_if(chosen.begin(), chosen.end(), [](const Coarsening& c) { return c.leftOut == 0; }));
  }
  EXPECT_LE(slow, kMotions / 2);
  EXPECT_GT(slow, 0) << "for good";
}

TEST(LeavingOutRule, ComesBackWhenTheLoadIsGone) {
  LeavingOutRule rule;
  EXPECT_EQ((move(rule, {{{400.0, 100.0}, {50.0, 75.0}, {20.0, 40.0}}}, 60.0, 20).back().leftOut), 2);
  const CostOfGroups light{{{20.0, 50.0}, {5.0, 37.5}, {2.0, 20.0}}};  // a fifth and less
  int motions = 0;
  while (move(rule, light, 60.0, 20).back().leftOut > 0) ASSERT_LT(++motions, 5);
  EXPECT_LE(motions, 1);
}

TEST(LeavingOutRule, OtherSettingsAreOtherMarches) {
  LeavingOutRule rule;
  move(rule, {{{200.0, 50.0}, {150.0, 40.0}, {100.0, 30.0}}}, 20.0, 20);
  EXPECT_EQ(rule.choose(kPixels, MarchSettings{}, 20.0), Coarsening{});
}

TEST(LeavingOutRule, TheCopyOfTheVolumeMakesNoOtherMarch) {
  LeavingOutRule rule;
  MarchSettings asked;
  asked.sample.proxy = 64;  // as a connection's first request has it
  rule.noteAtRest(kPixels, asked, 100.0);
  asked.sample.proxy = 0;  // and those behind it
  EXPECT_GT(rule.choose(kPixels, asked, 50.0).factor, 1.5);
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
    pace_.note(from(x), asked_, marched, tookMs, now_);
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

TEST_F(ServerPaceTest, EffectsComeBackWhenTheCameraRests) {
  asked_ = shadowed();
  const auto marchedFrom = [&](float x, int afterMs) {
    now_ += milliseconds(afterMs);
    const MarchSettings marched = pace_.settingsFor(from(x), asked_, 20.0, now_);
    now_ += milliseconds(100);
    pace_.note(from(x), asked_, marched, marched.render.effects.shadows.strength > 0.0f ? 100.0 : 10.0, now_);
    return marched;
  };
  EXPECT_EQ(marchedFrom(1, 0), asked_);
  for (const float x : {2.0f, 3.0f, 4.0f}) marchedFrom(x, 5);
  EXPECT_EQ(marchedFrom(5, 5).render.effects.shadows.strength, 0.0f);
  EXPECT_EQ(marchedFrom(5, 5), asked_) << "asked for again";
}

TEST(Coarsening, TheStepGrowsAndStaysInItsRange) {
  MarchSettings asked;
  asked.sample.threshold = 0.3f;
  EXPECT_EQ(coarsened(asked, {1.0}), asked);
  EXPECT_EQ(coarsened(asked, {0.1}), asked);
  EXPECT_EQ(coarsened(asked, {std::nan("")}), asked);
  MarchSettings expected = asked;
  expected.render.step = 1.25f;
  EXPECT_EQ(coarsened(asked, {2.5}), expected);
  EXPECT_EQ(coarsened(asked, {1e9}).render.step, static_cast<float>(0.5 * kMostCoarsening));
  asked.render.step = 900.0f;
  EXPECT_EQ(coarsened(asked, {4.0}).render.step, 1000.0f);
  EXPECT_NO_THROW(validate(coarsened(asked, {4.0})));
}

TEST(Coarsening, IsToldFromEverythingElse) {
  MarchSettings asked;
  EXPECT_FALSE(isCoarsened(asked, asked));
  for (const double factor : {1.0001, 1.5, 2.0, 3.7, 4.0, 50.0}) {
    const MarchSettings marched = coarsened(asked, {factor});
    EXPECT_TRUE(isCoarsened(asked, marched)) << factor;
    EXPECT_NEAR(coarseningOf(asked, marched)->factor, std::min(factor, kMostCoarsening), 1e-6);
    EXPECT_FALSE(isCoarsened(marched, asked)) << "finer than asked for";
  }
  MarchSettings other = coarsened(asked, {2.0});
  other.sample.heuristic = Heuristic::exit;
  EXPECT_FALSE(isCoarsened(asked, other));
  other = coarsened(asked, {2.0});
  other.render.contribution *= 2.0f;
  EXPECT_FALSE(isCoarsened(asked, other));
  other = asked;
  other.render.step = asked.render.step * static_cast<float>(1.001 * kMostCoarsening);
  EXPECT_FALSE(isCoarsened(asked, other));
  other.render.step = std::nanf("");
  EXPECT_FALSE(isCoarsened(asked, other));
}

TEST(Coarsening, EffectsGoTheDearestFirst) {
  MarchSettings asked = shadowed();
  asked.render.effects.shadows.occlusion = 0.3f;
  asked.render.effects.preIntegration = true;
  EXPECT_EQ(mostLeftOut(asked), 2);
  MarchSettings expected = asked;
  expected.render.effects.shadows.strength = expected.render.effects.shadows.occlusion = 0.0f;
  expected.render.effects.preIntegration = false;
  EXPECT_EQ((coarsened(asked, {1.0, 1})), expected);
  expected.render.effects.shading.strength = 0.0f;
  EXPECT_EQ((coarsened(asked, {1.0, 2})), expected);
  EXPECT_EQ((coarsened(asked, {1.0, 99})), expected);
  expected.render.step = 1.0f;
  EXPECT_EQ((coarsened(asked, {2.0, 2})), expected);
  for (const int leftOut : {0, 1, 2})
    for (const double factor : {1.0, 2.0}) {
      EXPECT_EQ((coarseningOf(asked, coarsened(asked, {factor, leftOut}))), (Coarsening{factor, leftOut}));
      EXPECT_EQ((isCoarsened(asked, coarsened(asked, {factor, leftOut}))), leftOut > 0 || factor > 1.0);
    }
  MarchSettings other = asked;
  other.render.effects.shading.strength = 0.0f;  // the last before the first
  EXPECT_EQ(coarseningOf(asked, other), std::nullopt);

  asked.render.effects = {};
  EXPECT_EQ(mostLeftOut(asked), 0);
  asked.render.effects.shading.strength = 1.0f;
  EXPECT_EQ(mostLeftOut(asked), 1) << "groups that nothing is in do not count";
  EXPECT_EQ((coarsened(asked, {1.0, 1})), MarchSettings{});
}

TEST(Coarsening, SaysWhatItLeavesOut) {
  MarchSettings asked;
  EXPECT_EQ(coarseningText(asked, asked), "");
  EXPECT_EQ(coarseningText(asked, coarsened(asked, {2.4})), "step 1.2 instead of 0.5");
  asked = shadowed();
  EXPECT_EQ((coarseningText(asked, coarsened(asked, {2.0, 2}))), "step 1 instead of 0.5, without shading, shadows");
  asked.render.effects.preIntegration = true;
  EXPECT_EQ(coarseningText(asked, coarsened(asked, {1.0, 1})), "without shadows, pre-integration");
}

}  // namespace
}  // namespace warpscope
