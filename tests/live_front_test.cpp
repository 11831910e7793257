// Points, means, medians, the front and its bounds.
// Mirrors app/experiment/live_front.h.
#include "app/experiment/live_front.h"
#include "render/warp/multihit_warp.h"

#include <gtest/gtest.h>

#include <limits>

namespace warpscope {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

Configuration configured(const char* technique, float step = 0.5f) {
  Configuration configuration;
  configuration.technique = &findWarp(technique);
  configuration.march.render.step = step;
  configuration.serverSidePx = 512;
  return configuration;
}

TEST(LiveFront, APointAppearsWithItsFirstError) {
  LiveFront front;
  front.addError(configured("spheres"), 0.0, 0.1);  // without a time it says nothing
  EXPECT_EQ(front.remembered(), 0u);
  front.addPicture(configured("spheres"), 3.0, 20.0);
  EXPECT_EQ(front.remembered(), 1u);
  EXPECT_TRUE(front.points().empty());
  front.addError(configured("spheres"), 0.0, 0.125);
  ASSERT_EQ(front.points().size(), 1u);
  EXPECT_EQ(front.points()[0].configuration, normalized(configured("spheres")));
  EXPECT_EQ(front.points()[0].frameMs, 23.0);
  EXPECT_EQ(front.points()[0].flip, 0.125);
  EXPECT_EQ(front.front(), std::vector<size_t>{0});
}

TEST(LiveFront, EqualWorkIsOnePoint) {
  LiveFront front;
  Configuration one = configured("points"), other = one;
  other.knobs.set(kHitsKnob, 9);  // points depend on none
  other.march.sample.radiusPolicy = RadiusPolicy::opacity;
  for (const Configuration& configuration : {one, other}) {
    front.addPicture(configuration, 1.0, 2.0);
    front.addError(configuration, 0.0, 0.25);
  }
  ASSERT_EQ(front.points().size(), 1u);
  EXPECT_EQ(front.points()[0].buckets[0].count, 2u);
}

TEST(LiveFront, TimesAreMediansOfTheLast) {
  LiveFront front;
  const Configuration configuration = configured("spheres");
  front.addPicture(configuration, 500.0, 900.0);  // a first one that takes long
  front.addError(configuration, 0.0, 0.5);
  for (int i = 0; i < 4; ++i) front.addPicture(configuration, 4.0, 10.0 + i);
  EXPECT_EQ(front.points()[0].frameMs, 4.0 + 12.0);
  for (size_t i = 0; i < LiveFront::kMostTimes; ++i) front.addPicture(configuration, 1.0, 2.0);
  EXPECT_EQ(front.points()[0].frameMs, 3.0);
  front.addPicture(configuration, kNaN, 2.0);
  EXPECT_EQ(front.points()[0].frameMs, 3.0);
}

TEST(LiveFront, EveryAngleCountsAlike) {
  LiveFront front;
  const Configuration configuration = configured("spheres");
  front.addPicture(configuration, 1.0, 1.0);
  for (int i = 0; i < 3; ++i) front.addError(configuration, 0.0, 0.1);
  front.addError(configuration, 2.4, 0.3);
  front.addError(configuration, -11.0, 0.5);
  front.addError(configuration, 10.0, 0.7);
  front.addError(configuration, 175.0, 0.9);
  front.addError(configuration, kNaN, 0.9);
  front.addError(configuration, 0.0, kNaN);
  const LiveFront::Point& point = front.points()[0];
  ASSERT_EQ(point.buckets.size(), 3u);
  EXPECT_EQ(point.buckets[0].fromDeg, 0.0);
  EXPECT_EQ(point.buckets[0].count, 4u);
  EXPECT_NEAR(point.buckets[0].flip, 0.15, 1e-12);
  EXPECT_EQ(point.buckets[1].fromDeg, 10.0);
  EXPECT_NEAR(point.buckets[1].flip, 0.6, 1e-12);
  EXPECT_EQ(point.buckets[2].fromDeg, 87.5);  // and above
  EXPECT_NEAR(point.flip, (0.15 + 0.6 + 0.9) / 3.0, 1e-12);
}

TEST(LiveFront, TheFrontIsWhatNothingBeats) {
  LiveFront front;
  const auto add = [&](const char* technique, double ms, double flip) {
    front.addPicture(configured(technique), 0.0, ms);
    front.addError(configured(technique), 0.0, flip);
  };
  add("spheres", 20.0, 0.05);
  add("points", 5.0, 0.10);
  add("multihit", 30.0, 0.08);  // slower and worse than spheres
  add("hold", 1.0, 0.40);
  add("reference", 0.5, 0.0);  // needs the volume: no competitor
  ASSERT_EQ(front.points().size(), 5u);
  EXPECT_EQ(front.front(), (std::vector<size_t>{3, 1, 0}));
}

TEST(LiveFront, IsBoundedAndKeepsWhatHasAnError) {
  LiveFront front;
  front.addPicture(configured("spheres"), 1.0, 1.0);
  front.addError(configured("spheres"), 0.0, 0.1);
  for (int i = 0; i < 1000; ++i) front.addPicture(configured("spheres", 1.0f + 0.001f * static_cast<float>(i)), 1.0, 1.0);  // a slider is dragged
  EXPECT_EQ(front.remembered(), LiveFront::kMostConfigurations);
  ASSERT_EQ(front.points().size(), 1u);
  EXPECT_EQ(front.points()[0].configuration.march.render.step, 0.5f);

  for (int i = 0; i < 1000; ++i) {
    const Configuration configuration = configured("spheres", 10.0f + 0.01f * static_cast<float>(i));
    front.addPicture(configuration, 1.0, 1.0);
    front.addError(configuration, 0.0, 0.1);
  }
  EXPECT_EQ(front.remembered(), LiveFront::kMostConfigurations);
  EXPECT_EQ(front.points().size(), LiveFront::kMostConfigurations);
  for (const LiveFront::Point& point : front.points()) EXPECT_GT(point.configuration.march.render.step, 17.9f);  // the last ones
  front.clear();
  EXPECT_EQ(front.remembered(), 0u);
  EXPECT_TRUE(front.points().empty());
  EXPECT_TRUE(front.front().empty());
}

}  // namespace
}  // namespace warpscope
