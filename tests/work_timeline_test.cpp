// When threads marched and waited: no time is lost, whatever the slots' width.
#include "render/bricks/work_timeline.h"

#include <gtest/gtest.h>

#include <limits>
#include <numeric>
#include <random>

namespace warpscope {
namespace {

double sumOf(const std::array<float, WorkTimeline::kSlots>& slots) { return std::accumulate(slots.begin(), slots.end(), 0.0); }

TEST(WorkTimeline, TimeIsWhereItWasSpent) {
  WorkTimeline timeline;
  timeline.addMarch(0.0, 0.25);
  timeline.addWait(0.25, 0.5);
  timeline.addMarch(0.6, 0.9);
  EXPECT_DOUBLE_EQ(timeline.slotMs, 0.25);
  EXPECT_FLOAT_EQ(timeline.marchMs[0], 0.25f);
  EXPECT_FLOAT_EQ(timeline.waitMs[0], 0.0f);
  EXPECT_FLOAT_EQ(timeline.waitMs[1], 0.25f);
  EXPECT_NEAR(timeline.marchMs[2], 0.15, 1e-6);
  EXPECT_NEAR(timeline.marchMs[3], 0.15, 1e-6);
  EXPECT_NEAR(timeline.mostThreads(), 1.0, 1e-6);
  timeline.addMarch(0.0, 0.25);
  EXPECT_NEAR(timeline.mostThreads(), 2.0, 1e-6);
}

TEST(WorkTimeline, SlotsWidenAndNothingIsLost) {
  std::mt19937 random(7);
  WorkTimeline timeline;
  double marched = 0.0, waited = 0.0, end = 0.0;
  for (int i = 0; i < 2000; ++i) {
    const double begin = std::uniform_real_distribution<double>(0.0, 0.05 * i)(random), length = std::exponential_distribution<double>(1.0)(random);
    (i % 3 != 0 ? marched : waited) += length;
    end = std::max(end, begin + length);
    if (i % 3 != 0)
      timeline.addMarch(begin, begin + length);
    else
      timeline.addWait(begin, begin + length);
    ASSERT_NEAR(sumOf(timeline.marchMs), marched, 1e-4 * (marched + 1.0)) << i;
    ASSERT_NEAR(sumOf(timeline.waitMs), waited, 1e-4 * (waited + 1.0)) << i;
  }
  EXPECT_GE(timeline.slotMs * WorkTimeline::kSlots, end);
  EXPECT_LT(timeline.slotMs * WorkTimeline::kSlots, 2.0 * end);
}

TEST(WorkTimeline, WhatIsNoTimeIsLeftOut) {
  WorkTimeline timeline;
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN(), kEndless = std::numeric_limits<double>::infinity();
  for (const auto& [begin, end] : {std::pair{kNone, 1.0}, {0.0, kNone}, {0.0, kEndless}, {-1.0, 1.0}, {2.0, 1.0}, {1.0, 1.0}}) timeline.addMarch(begin, end);
  EXPECT_EQ(sumOf(timeline.marchMs), 0.0);
  EXPECT_DOUBLE_EQ(timeline.slotMs, 0.25);
  EXPECT_EQ(timeline.mostThreads(), 0.0);
}

}  // namespace
}  // namespace warpscope
