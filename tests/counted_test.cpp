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

/// Cases whose stage, decided in where it is not needed, is work for nothing.
class CountedForNothing : public Counted {};

TEST_P(CountedForNothing, ChangesNothing) {
  const CountedRun without = countedMarch(makeCpuMarcher, GetParam().without);
  EXPECT_TRUE(without.isSame(countedMarch(makeCpuMarcher, GetParam().without, DecidedStage{GetParam().stage, true})));
}

INSTANTIATE_TEST_SUITE_P(Stages, Counted, testing::ValuesIn(countedCases()), nameOfCase);
INSTANTIATE_TEST_SUITE_P(Stages, CountedForNothing, testing::ValuesIn([] {
  std::vector<CountedCase> cases = countedCases();
  // Rays end early where the settings say that they must not: that is seen.
  std::erase_if(cases, [](const CountedCase& one) { return one.stage == PlanStage::earlyEnd; });
  return cases;
}()), nameOfCase);

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

TEST(Counters, OfAnEmptyVolumeHardlyAnySampleIsLookedAt) {
  // One voxel of it is visible.
  const VolumePtr volume = makeTestVolume(VoxelType::uint8, {256, 256, 64}, [](const glm::ivec3& p) { return p == glm::ivec3(0) ? 255.0 : 0.0; });
  const MarcherPtr marcher = makeCpuMarcher(volume, band(100.0, 256.0, 0.5f));
  const auto samplesIf = [&](bool skips) {
    MarchSettings settings;
    settings.render.skipEmpty = skips;
    HostCounts::instance().take();
    marcher->march(lookingFrom({300.0f, 250.0f, 200.0f}, {}, 48, 48), settings);
    return HostCounts::instance().take()[Counter::samples];
  };
  EXPECT_LT(samplesIf(true) * 100, samplesIf(false));
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
