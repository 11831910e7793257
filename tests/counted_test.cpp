// What a plan leaves out is not done, not once; what it has is. And no rule of the plan is idle: decided otherwise, it does work for nothing, or shows
// in pixels. Mirrors render/core/counters.h; the march is compiled with its counters.
#include "render/core/counters.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "counted_cases.h"
#include "render/march/marcher_cpu.h"

namespace warpscope {
namespace {

class Counted : public testing::TestWithParam<CountedCase> {};

TEST_P(Counted, StagesThatAreOutDoNothing) {
  const CountedRun run = countedMarch(makeCpuMarcher, GetParam().without);
  ASSERT_FALSE(run.plan.has(GetParam().stage)) << run.plan[GetParam().stage].reason;
  EXPECT_EQ(run.counts[GetParam().counter], 0u);
}

TEST_P(Counted, StagesThatAreInDoSomething) {
  const CountedRun run = countedMarch(makeCpuMarcher, GetParam().with);
  ASSERT_TRUE(run.plan.has(GetParam().stage)) << run.plan[GetParam().stage].reason;
  EXPECT_GT(run.counts[GetParam().counter], 0u);
}

TEST_P(Counted, NoRuleIsIdle) {
  const CountedCase& one = GetParam();
  const CountedRun in = countedMarch(makeCpuMarcher, one.without, DecidedStage{one.stage, true});
  const bool isWork = in.counts[one.counter] > 0;
  const bool isSeen = !countedMarch(makeCpuMarcher, one.with).isSame(countedMarch(makeCpuMarcher, one.with, DecidedStage{one.stage, false}));
  EXPECT_EQ(isWork, one.isWork) << "decided in: " << in.counts[one.counter];
  EXPECT_EQ(isWork || isSeen, one.isAskedOf);
}

TEST_P(Counted, WhatIsDoneForNothingChangesNothing) {
  if (GetParam().stage == PlanStage::earlyEnd) return;  // not for nothing: rays end where the settings say that they must not
  const CountedRun without = countedMarch(makeCpuMarcher, GetParam().without);
  EXPECT_TRUE(without.isSame(countedMarch(makeCpuMarcher, GetParam().without, DecidedStage{GetParam().stage, true})));
}

INSTANTIATE_TEST_SUITE_P(Stages, Counted, testing::ValuesIn(countedCases()), nameOfCase);

TEST(Counters, EveryStageHasACase) {
  for (const StageDescriptor& stage : kStages)
    EXPECT_TRUE(std::ranges::any_of(countedCases(), [&](const CountedCase& one) { return one.stage == stage.stage; })) << stage.name;
}

/// Of an effect whose strength is 0 all other settings are as if they were not there: in the picture, in the samples and in what is done.
TEST(Counters, EffectsWithoutStrengthAreNotThere) {
  const CountedScene plain;
  const CountedRun expected = countedMarch(makeCpuMarcher, plain);
  for (const CountedScene& scene : scenesWithoutStrength()) {
    const CountedRun run = countedMarch(makeCpuMarcher, scene);
    EXPECT_TRUE(run.isSame(expected));
    EXPECT_EQ(run.counts, expected.counts);
  }
}

TEST(Counters, SpecularOfNoneLeavesTheLightThatThereIs) {
  CountedScene dull;
  dull.settings.render.effects.shading = {.strength = 1.0f, .specular = 0.0f};
  CountedScene sharp = dull;
  sharp.settings.render.effects.shading.exponent = 77.0f;
  EXPECT_TRUE(countedMarch(makeCpuMarcher, dull).isSame(countedMarch(makeCpuMarcher, sharp)));
}

/// One sample that counts on each ray, or the first one beyond any threshold: the first pass decides.
TEST(Counters, RaysThatTheFirstPassDecidesAreNotMarchedAgain) {
  for (const Heuristic heuristic : {Heuristic::relThreshold, Heuristic::enExMean, Heuristic::median}) {
    CountedScene opaque;
    opaque.opacity = 1.0f;
    opaque.settings.sample.heuristic = heuristic;
    EXPECT_EQ(countedMarch(makeCpuMarcher, opaque).counts[Counter::secondPasses], 0u) << nameOf(heuristic);
  }
}

TEST(Counters, CountsOfThreadsAreSummedAndTaken) {
  HostCounts::instance().take();
  std::vector<std::jthread> threads;
  for (int i = 0; i < 8; ++i)
    threads.emplace_back([] {
      for (int k = 0; k < 1000; ++k) WARPSCOPE_COUNT(secondaryRays, 2);
    });
  threads.clear();
  EXPECT_EQ(HostCounts::instance().take()[Counter::secondaryRays], 16000u);
  EXPECT_EQ(HostCounts::instance().take(), Counts{});
}

}  // namespace
}  // namespace warpscope
