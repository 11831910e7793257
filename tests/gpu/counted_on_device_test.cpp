// What a plan leaves out is not done on a device either, and the device does as much as the CPU where both count the same.
// Mirrors render/core/counters.h.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "render/cuda/devices.h"
#include "render/march/marcher_cpu.h"
#include "render/march/marcher_cuda.h"
#include "tests/counted_cases.h"

namespace warpscope {
namespace {

class CountedOnDevice : public testing::TestWithParam<CountedCase> {
 protected:
  void SetUp() override {
    if (const std::string reason = cuda::whyUnavailable(); !reason.empty()) GTEST_SKIP() << "no GPU here: " << reason;
  }
};

TEST_P(CountedOnDevice, StagesThatAreOutDoNothing) {
  const CountedRun run = countedMarch(makeCudaMarcher, GetParam().without);
  ASSERT_FALSE(run.plan.has(GetParam().stage));
  EXPECT_EQ(run.counts[GetParam().counter], 0u);
}

TEST_P(CountedOnDevice, StagesThatAreInDoSomething) {
  const CountedRun run = countedMarch(makeCudaMarcher, GetParam().with);
  ASSERT_TRUE(run.plan.has(GetParam().stage));
  EXPECT_GT(run.counts[GetParam().counter], 0u);
}

TEST_P(CountedOnDevice, DoesAsMuchAsTheCpu) {
  for (const CountedScene& scene : {GetParam().without, GetParam().with}) {
    const CountedRun cpu = countedMarch(makeCpuMarcher, scene), device = countedMarch(makeCudaMarcher, scene);
    EXPECT_TRUE(device.isSame(cpu));
    if (scene.settings.sample.samplesPerRay > 1) continue;  // the device marches such rays once more
    EXPECT_EQ(device.counts[Counter::secondPasses], cpu.counts[Counter::secondPasses]);
    if (device.plan.has(PlanStage::secondPass)) continue;  // whose marches end as well
    EXPECT_EQ(device.counts[Counter::earlyEnds], cpu.counts[Counter::earlyEnds]);
  }
}

TEST_P(CountedOnDevice, NoRuleIsIdle) {
  const CountedCase& one = GetParam();
  const bool isWork = countedMarch(makeCudaMarcher, one.without, DecidedStage{one.stage, true}).counts[one.counter] > 0;
  const bool isSeen = !countedMarch(makeCudaMarcher, one.with).isSame(countedMarch(makeCudaMarcher, one.with, DecidedStage{one.stage, false}));
  EXPECT_EQ(isWork || isSeen, one.isAskedOf);
}

/// Those whose volumes there are kernels for.
std::vector<CountedCase> casesOfBytes() {
  std::vector<CountedCase> cases = countedCases();
  std::erase_if(cases, [](const CountedCase& one) { return one.with.type != VoxelType::uint8; });
  return cases;
}
INSTANTIATE_TEST_SUITE_P(Stages, CountedOnDevice, testing::ValuesIn(casesOfBytes()), nameOfCase);

TEST(CountersOnDevice, RaysThatTheFirstPassDecidesAreNotMarchedAgain) {
  if (const std::string reason = cuda::whyUnavailable(); !reason.empty()) GTEST_SKIP() << "no GPU here: " << reason;
  for (const Heuristic heuristic : {Heuristic::relThreshold, Heuristic::enExMean, Heuristic::median}) {
    CountedScene opaque;
    opaque.opacity = 1.0f;
    opaque.settings.sample.heuristic = heuristic;
    EXPECT_EQ(countedMarch(makeCudaMarcher, opaque).counts[Counter::secondPasses], 0u) << nameOf(heuristic);
  }
}

}  // namespace
}  // namespace warpscope
