// Steps of an error over the last seconds, in virtual time.
// Mirrors app/session/error_history.h.
#include "app/session/error_history.h"

#include <gtest/gtest.h>

namespace warpscope {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

const Clock::TimePoint kStart = Clock::TimePoint{} + seconds(1000);

TEST(ErrorHistory, AValueHoldsUntilTheNext) {
  ErrorHistory history;
  EXPECT_TRUE(history.steps(kStart).empty());
  history.add(kStart, 0.25);
  history.add(kStart + seconds(2), 0.5);
  const auto steps = history.steps(kStart + seconds(3));
  ASSERT_EQ(steps.size(), 2u);
  EXPECT_DOUBLE_EQ(steps[0].beginS, 3.0);
  EXPECT_DOUBLE_EQ(steps[0].endS, 1.0);
  EXPECT_EQ(steps[0].value, 0.25);
  EXPECT_DOUBLE_EQ(steps[1].beginS, 1.0);
  EXPECT_EQ(steps[1].endS, 0.0);
  EXPECT_EQ(steps[1].value, 0.5);
}

TEST(ErrorHistory, AValueThatIsNoLongerTrueEnds) {
  ErrorHistory history;
  history.interrupt(kStart);  // nothing there to end
  history.add(kStart, 0.25);
  history.interrupt(kStart + seconds(1));
  history.interrupt(kStart + seconds(2));  // it has ended already
  history.add(kStart + seconds(3), 0.5);
  const auto steps = history.steps(kStart + seconds(4));
  ASSERT_EQ(steps.size(), 2u);
  EXPECT_DOUBLE_EQ(steps[0].beginS, 4.0);
  EXPECT_DOUBLE_EQ(steps[0].endS, 3.0);
  EXPECT_DOUBLE_EQ(steps[1].beginS, 1.0);
}

TEST(ErrorHistory, OnlyTheLastSecondsCount) {
  ErrorHistory history;
  history.add(kStart, 0.25);
  history.add(kStart + seconds(1), 0.5);
  EXPECT_EQ(history.steps(kStart + seconds(10)).size(), 2u);
  const auto steps = history.steps(kStart + seconds(12));  // the first ended eleven seconds ago, the second holds since then
  ASSERT_EQ(steps.size(), 1u);
  EXPECT_EQ(steps[0].beginS, 10.0);
  EXPECT_EQ(steps[0].endS, 0.0);
  EXPECT_EQ(steps[0].value, 0.5);
}

TEST(ErrorHistory, OfTooManyValuesTheOldestGo) {
  ErrorHistory history;
  const int many = static_cast<int>(ErrorHistory::kMost) * 3 + 7;
  for (int i = 0; i < many; ++i) history.add(kStart + milliseconds(i), i);
  const auto steps = history.steps(kStart + milliseconds(many));
  ASSERT_EQ(steps.size(), ErrorHistory::kMost);
  EXPECT_EQ(steps.back().value, many - 1);
  EXPECT_EQ(steps.front().value, many - static_cast<int>(ErrorHistory::kMost));
  for (size_t i = 1; i < steps.size(); ++i) EXPECT_DOUBLE_EQ(steps[i].beginS, steps[i - 1].endS);
}

}  // namespace
}  // namespace warpscope
