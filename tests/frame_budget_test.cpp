// Frames of no more bytes than they may have: the rule against frames whose bytes grow as any power of their pixels, the search against every size, and real frames.
// Mirrors app/frames/frame_budget.h.
#include "app/frames/frame_budget.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "render/base/error.h"
#include "tests/headless.h"

namespace warpscope {
namespace {

Camera sized(uint32_t width, uint32_t height) {
  Camera camera;
  camera.width = width;
  camera.height = height;
  return camera;
}

MarchSettings withSegments(int segments) {
  MarchSettings settings;
  settings.sample.segments = segments;
  return settings;
}

/// Bytes as a power of the pixels.
struct Growth {
  double aPixel = 3.0, exponent = 0.85;
  size_t of(const Camera& camera) const { return static_cast<size_t>(aPixel * std::pow(static_cast<double>(camera.width) * camera.height, exponent)); }
};

/// A server whose frames take that, and the cameras it was asked for.
FrameFetch frames(const Growth& growth, std::vector<Camera>& asked) {
  return [&growth, &asked](const Camera& camera, const MarchSettings& settings, const std::stop_token&) {
    asked.push_back(camera);
    auto frame = std::make_shared<SampleFrame>();
    frame->camera = camera;
    frame->settings = settings;
    ServedFrame served;
    served.frame = std::move(frame);
    served.bytes.segments = growth.of(camera);
    served.bytes.proxy = asked.size() == 1 ? 777 : 0;  // once a connection
    return served;
  };
}

TEST(FrameSizes, KeepTheShapeAndNeverVanish) {
  const Camera full = sized(1600, 900);
  EXPECT_EQ(longerSide(full), 1600u);
  EXPECT_EQ(ofLongerSide(full, 1600), full);
  EXPECT_EQ(ofLongerSide(full, 800), sized(800, 450));
  EXPECT_EQ(ofLongerSide(sized(2000, 1), 64), sized(64, 1));
  EXPECT_EQ(longerSide(ofLongerSide(sized(1, 2000), 1)), 1u);
}

TEST(FrameSizes, GrowByAtLeastAPixelAndNotBeyondTheWhole) {
  const Camera full = sized(1024, 768);
  EXPECT_EQ(FrameSizeRule::grown(full, full, 2.0), full);
  EXPECT_EQ(FrameSizeRule::grown(sized(900, 675), full, 2.0), full);
  EXPECT_EQ(longerSide(FrameSizeRule::grown(sized(200, 150), full, 1.0001)), 201u);
  const Growth growth;
  const double factor = static_cast<double>(growth.of(FrameSizeRule::grown(sized(300, 225), full, 2.0))) / static_cast<double>(growth.of(sized(300, 225)));
  EXPECT_NEAR(factor, 2.0, 0.05);
}

TEST(FrameSizeRule, FitsWithinAFewFrames) {
  const Camera full = sized(1024, 1024);
  const MarchSettings settings = withSegments(4);
  for (const double exponent : {0.6, 0.75, 0.85, 1.0})
    for (const double aPixel : {0.05, 2.0, 60.0})
      for (const double budget : {20e3, 200e3, 1e6}) {
        const Growth growth{aPixel, exponent};
        if (growth.of(sized(64, 64)) > budget) continue;
        FrameSizeRule rule;
        uint32_t lastPx = 0;
        for (int i = 0; i < 12; ++i) {
          const Camera camera = rule.choose(full, settings, budget);
          const size_t took = growth.of(camera);
          rule.note(camera, settings, static_cast<double>(took));
          if (i < 5) continue;
          EXPECT_LE(static_cast<double>(took), budget) << exponent << " " << aPixel;
          if (camera != full) EXPECT_GE(static_cast<double>(took), 0.7 * budget) << exponent << " " << aPixel;
          if (i > 8) EXPECT_EQ(longerSide(camera), lastPx) << "nothing has changed";
          lastPx = longerSide(camera);
        }
      }
}

TEST(FrameSizeRule, KnowsMoreSegmentsForMoreBytes) {
  const Camera full = sized(1024, 1024);
  FrameSizeRule rule;
  rule.note(full, withSegments(0), 1e6);
  EXPECT_EQ(rule.choose(full, withSegments(0), 1.01e6), full);
  EXPECT_LT(longerSide(rule.choose(full, withSegments(8), 1.01e6)), 512u);
}

TEST(FrameSizeRule, FollowsAPanelOfAnotherShape) {
  FrameSizeRule rule;
  rule.note(sized(800, 600), withSegments(0), 1e6);
  const Camera wide = rule.choose(sized(800, 600), withSegments(0), 2e5);
  const Camera tall = rule.choose(sized(300, 500), withSegments(0), 1e5);
  EXPECT_EQ(tall, ofLongerSide(sized(300, 500), longerSide(tall)));
  EXPECT_LE(longerSide(tall), 500u);
  EXPECT_EQ(wide, ofLongerSide(sized(800, 600), longerSide(wide)));
  // Too little for any picture, and a picture that is smaller than the smallest.
  EXPECT_EQ(longerSide(rule.choose(sized(800, 600), withSegments(0), 1.0)), FrameSizeRule::kLeastSidePx);
  EXPECT_EQ(longerSide(rule.choose(sized(9, 12), withSegments(0), 1.0)), 12u);
}

TEST(WithinBudget, FindsNearlyTheLargestThatFits) {
  const Camera full = sized(1024, 640);
  for (const double exponent : {0.5, 0.7, 0.85, 1.0, 1.2})
    for (const double share : {0.012, 0.1, 0.3, 0.5, 0.95, 1.0, 5.0}) {
      const Growth growth{4.0, exponent};
      const auto budget = static_cast<uint64_t>(share * static_cast<double>(growth.of(full)));
      if (growth.of(ofLongerSide(full, 64)) > budget) continue;
      std::vector<Camera> asked;
      const ServedFrame served = withinBudget(frames(growth, asked), budget)(full, withSegments(4), {});
      EXPECT_LE(served.bytes.ofFrame(), budget);
      EXPECT_EQ(served.bytes.ofFrame(), growth.of(served.frame->camera)) << "of that frame, not of another";
      EXPECT_EQ(served.bytes.proxy, 777u) << "which came with the first";
      const bool isNear = static_cast<double>(served.bytes.ofFrame()) >= 0.9 * static_cast<double>(budget) || growth.of(ofLongerSide(full, longerSide(served.frame->camera) + 4)) > budget;
      EXPECT_TRUE(served.frame->camera == full || isNear) << exponent << " " << share << " " << longerSide(served.frame->camera);
      EXPECT_LE(asked.size(), 8u) << exponent << " " << share;
    }
}

TEST(WithinBudget, TakesFramesOfFewPixelsAsTheyAre) {
  const Growth growth;
  std::vector<Camera> asked;
  EXPECT_EQ(withinBudget(frames(growth, asked), 1000)(sized(3, 2), withSegments(0), {}).frame->camera, sized(3, 2));
  EXPECT_EQ(asked.size(), 1u);
}

TEST(WithinBudget, SaysWhatTheSmallestTakes) {
  const Growth growth;
  std::vector<Camera> asked;
  try {
    withinBudget(frames(growth, asked), 1024)(sized(1024, 512), withSegments(4), {});
    FAIL() << "nothing fits";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("64x32 pixels"), std::string::npos) << error.what();
    EXPECT_NE(std::string(error.what()).find(std::to_string(growth.of(sized(64, 32)))), std::string::npos) << error.what();
  }
}

TEST(WithinBudget, HoldsForRealFramesAndIsTheSameEveryTime) {
  const Stage stage(smallScene("shells"));
  CodecSettings codec;
  MarchSettings settings = stage.scene().march;
  settings.sample.segments = 4;
  settings.sample.proxy = 8;
  const Camera full = makeCamera(stage.scene(), stage.scene().views.front(), 160, 120);
  const ServedFrame whole = fetchHere(stage.resources().marcher, codec)(full, settings, {});
  const uint64_t budget = whole.bytes.ofFrame() / 2;
  const ServedFrame first = withinBudget(fetchHere(stage.resources().marcher, codec), budget)(full, settings, {});
  EXPECT_LE(first.bytes.ofFrame(), budget);
  EXPECT_GE(first.bytes.ofFrame(), budget * 8 / 10);
  EXPECT_LT(first.frame->camera.width, full.width);
  EXPECT_EQ(first.bytes.proxy, whole.bytes.proxy);
  const ServedFrame second = withinBudget(fetchHere(stage.resources().marcher, codec), budget)(full, settings, {});
  EXPECT_EQ(second.frame->camera, first.frame->camera);
  EXPECT_EQ(second.bytes, first.bytes);
}

}  // namespace
}  // namespace warpscope
