// Double clicks: what is one and what is none, with pictures drawn fast and seldom.
// Mirrors app/ui/double_click.h.
#include "app/ui/double_click.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace warpscope::ui {
namespace {

constexpr glm::dvec2 kPlace(200.0, 100.0);

Clock::TimePoint at(double ms) { return Clock::TimePoint() + durationOfMs(ms); }

/// A press that was known of as it happened.
bool pressAt(DoubleClick& clicks, double ms, const glm::dvec2& place = kPlace) {
  return clicks.press({at(ms), at(ms)}, place, DoubleClick::kReachPx);
}

TEST(DoubleClick, TwoPressesWithinItsTimeAreOne) {
  for (const double gapMs : {0.0, 1.0, 120.0, 350.0}) {
    DoubleClick clicks;
    EXPECT_FALSE(pressAt(clicks, 1000.0));
    EXPECT_TRUE(pressAt(clicks, 1000.0 + gapMs)) << gapMs;
  }
}

TEST(DoubleClick, LaterPressesAreTwo) {
  DoubleClick clicks;
  EXPECT_FALSE(pressAt(clicks, 0.0));
  EXPECT_FALSE(pressAt(clicks, 351.0));
  EXPECT_TRUE(pressAt(clicks, 600.0)) << "the press that came too late is the first of the next";
}

TEST(DoubleClick, PressesFarApartAreTwo) {
  DoubleClick clicks;
  EXPECT_FALSE(pressAt(clicks, 0.0));
  EXPECT_FALSE(pressAt(clicks, 100.0, kPlace + glm::dvec2(5.0, 5.0)));
  EXPECT_TRUE(pressAt(clicks, 200.0, kPlace + glm::dvec2(5.0, 11.0)));
}

TEST(DoubleClick, ReachGrowsWithTheScale) {
  for (const double scale : {1.0, 2.0}) {
    DoubleClick clicks;
    EXPECT_FALSE(clicks.press({at(0.0), at(0.0)}, kPlace, scale * DoubleClick::kReachPx));
    EXPECT_EQ(clicks.press({at(100.0), at(100.0)}, kPlace + glm::dvec2(9.0, 0.0), scale * DoubleClick::kReachPx), scale == 2.0);
  }
}

TEST(DoubleClick, AThirdPressIsTheFirstOfTheNext) {
  DoubleClick clicks;
  EXPECT_FALSE(pressAt(clicks, 0.0));
  EXPECT_TRUE(pressAt(clicks, 100.0));
  EXPECT_FALSE(pressAt(clicks, 200.0));
  EXPECT_TRUE(pressAt(clicks, 300.0));
}

/// A window that learns of events between its pictures only, at 5 and at 2 pictures a second.
TEST(DoubleClick, NoneIsMissedAtFewPicturesASecond) {
  std::mt19937 random(31);
  for (const double periodMs : {200.0, 500.0})
    for (int round = 0; round < 1000; ++round) {
      const double firstMs = std::uniform_real_distribution(0.0, periodMs)(random);
      const double secondMs = firstMs + std::uniform_real_distribution(0.0, 350.0)(random);
      const auto learnt = [&](double ms) {
        const double before = std::floor(ms / periodMs) * periodMs;
        return Moment{at(before), at(before + periodMs)};
      };
      DoubleClick clicks;
      ASSERT_FALSE(clicks.press(learnt(firstMs), kPlace, DoubleClick::kReachPx));
      ASSERT_TRUE(clicks.press(learnt(secondMs), kPlace, DoubleClick::kReachPx)) << "seed 31, round " << round << ": " << firstMs << " and " << secondMs;
    }
}

TEST(DoubleClick, PressesThatMustLieFurtherApartAreTwoAtFewPicturesASecond) {
  DoubleClick clicks;
  EXPECT_FALSE(clicks.press({at(0.0), at(200.0)}, kPlace, DoubleClick::kReachPx));
  EXPECT_FALSE(clicks.press({at(600.0), at(800.0)}, kPlace, DoubleClick::kReachPx));
}

}  // namespace
}  // namespace warpscope::ui
