// Gaps filled from what lies about them: which are, and with what.
// Mirrors render/warp/pull_push.h.
#include <gtest/gtest.h>

#include "render/base/error.h"
#include "render/warp/pull_push.h"

namespace warpscope {
namespace {

/// Covered where `isCovered(x, y)`, with a colour that goes straight along both axes.
template <class IsCovered>
WarpedImage imageOf(uint32_t width, uint32_t height, const IsCovered& isCovered) {
  WarpedImage image;
  image.samples.resize(width, height, kNoSample);
  image.color.resize(width, height);
  for (uint32_t y = 0; y < height; ++y)
    for (uint32_t x = 0; x < width; ++x) {
      if (!isCovered(x, y)) continue;
      image.samples(x, y) = y * width + x;
      image.color(x, y) = {0.01f * static_cast<float>(x), 0.01f * static_cast<float>(y), 0.25f, 0.5f};
    }
  return image;
}

TEST(PullPush, OneColourStaysThatColourHoweverLargeTheGap) {
  for (const uint32_t side : {3u, 17u, 64u, 200u}) {
    WarpedImage image = imageOf(side, side, [&](uint32_t x, uint32_t y) { return x == 0 || y == 0 || x == side - 1 || y == side - 1; });
    for (glm::vec4& color : image.color) color = color.a > 0.0f ? glm::vec4(0.3f, 0.2f, 0.1f, 0.7f) : color;
    fillGaps(image);
    for (size_t i = 0; i < image.color.size(); ++i) {
      ASSERT_NE(image.samples[i], kNoSample);
      for (int channel = 0; channel < 4; ++channel) ASSERT_NEAR(image.color[i][channel], glm::vec4(0.3f, 0.2f, 0.1f, 0.7f)[channel], 1e-6f) << side;
    }
  }
}

TEST(PullPush, SmallGapsGoOnAsTheirNeighboursDo) {
  WarpedImage image = imageOf(60, 50, [](uint32_t x, uint32_t y) { return (x * 7 + y * 3) % 11 != 0; });
  const WarpedImage before = image;
  fillGaps(image);
  for (uint32_t y = 2; y < 48; ++y)
    for (uint32_t x = 2; x < 58; ++x) {
      if (before.samples(x, y) != kNoSample) {
        ASSERT_EQ(image.samples(x, y), before.samples(x, y));
        ASSERT_EQ(image.color(x, y), before.color(x, y));
        continue;
      }
      ASSERT_EQ(image.samples(x, y), kFilled);
      ASSERT_NEAR(image.color(x, y).r, 0.01f * static_cast<float>(x), 0.012f);
      ASSERT_NEAR(image.color(x, y).g, 0.01f * static_cast<float>(y), 0.012f);
      ASSERT_NEAR(image.color(x, y).a, 0.5f, 1e-6f);
    }
}

TEST(PullPush, WhatIsNotEnclosedStaysBackground) {
  const auto isRing = [](uint32_t x, uint32_t y) {
    const int dx = static_cast<int>(x) - 40, dy = static_cast<int>(y) - 30, squared = dx * dx + dy * dy;
    return squared >= 100 && squared <= 400;
  };
  WarpedImage image = imageOf(80, 60, isRing);
  fillGaps(image);
  for (uint32_t y = 0; y < 60; ++y)
    for (uint32_t x = 0; x < 80; ++x) {
      const int dx = static_cast<int>(x) - 40, dy = static_cast<int>(y) - 30;
      if (dx * dx + dy * dy < 100) {
        EXPECT_EQ(image.samples(x, y), kFilled);
      } else if (!isRing(x, y)) {
        ASSERT_EQ(image.samples(x, y), kNoSample) << x << ", " << y;
        ASSERT_EQ(image.color(x, y), glm::vec4(0.0f));
      }
    }
  // A side of it open: what sees covered pixels to three sides is taken for a gap, what sees them to two is not.
  WarpedImage open = imageOf(80, 60, [&](uint32_t x, uint32_t y) { return isRing(x, y) && x < 46; });
  fillGaps(open);
  EXPECT_EQ(open.samples(40, 30), kFilled);
  EXPECT_EQ(open.samples(70, 30), kNoSample);
}

TEST(PullPush, NothingAndAllAndOnePixelStayAsTheyAre) {
  for (const uint32_t width : {1u, 2u, 33u})
    for (const uint32_t height : {1u, 2u, 20u})
      for (const bool isCovered : {false, true}) {
        WarpedImage image = imageOf(width, height, [&](uint32_t, uint32_t) { return isCovered; });
        const WarpedImage before = image;
        fillGaps(image);
        EXPECT_EQ(image.samples, before.samples);
        EXPECT_EQ(image.color, before.color);
      }
}

TEST(PullPush, StoppedItLeavesThePictureAsItWas) {
  WarpedImage image = imageOf(60, 50, [](uint32_t x, uint32_t y) { return (x + y) % 3 != 0; });
  const WarpedImage before = image;
  std::stop_source stop;
  stop.request_stop();
  EXPECT_THROW(fillGaps(image, stop.get_token()), OperationCancelled);
  EXPECT_EQ(image.samples, before.samples);
  EXPECT_EQ(image.color, before.color);
}

}  // namespace
}  // namespace warpscope
