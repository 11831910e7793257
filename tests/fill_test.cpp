// Gaps that are filled: by the copy of the volume, by what lies about them, or not at all; how filled pixels are counted, marked, and what they cost.
// Mirrors render/warp/fill.h, render/warp/completed_warp.h, render/warp/proxy_fill.h, render/warp/proxy_warp.h.
#include <gtest/gtest.h>

#include "app/frames/frame_fetch.h"
#include "app/picture/picture.h"
#include "render/metrics/holes.h"
#include "render/metrics/psnr.h"
#include "render/warp/fill.h"
#include "warp_cases.h"

namespace warpscope {
namespace {

WarpSettings filledBy(Fill fill) {
  WarpSettings settings;
  settings.knobs.set(kFillKnob, fill);
  return settings;
}

class FillTest : public testing::Test {
 protected:
  FillTest() : stage_(smallScene("block", 64)) {
    MarchSettings march = stage_.scene().march;
    march.sample.segments = 4;
    march.sample.proxy = 32;
    frame_ = stage_.frame(stage_.camera(120, 90), march);
    camera_ = stage_.camera(120, 90, 30.0);
    stage_.marcher().render(camera_, march.render, reference_);
  }

  WarpedImage draw(std::string_view technique, Fill fill) const { return stage_.draw(technique, frame_, camera_, filledBy(fill)); }

  Stage stage_;
  SampleFramePtr frame_;
  Camera camera_;
  Image<glm::vec4> reference_;
};

TEST_F(FillTest, EveryTechniqueThatLeavesGapsHasTheKnobAndNoOther) {
  for (const WarpDescriptor& technique : warpRegistry()) {
    EXPECT_EQ(technique.has(kFillKnob), technique.uses.depth || technique.uses.segments) << technique.name;
    EXPECT_EQ(leavesGaps(technique), technique.has(kFillKnob)) << technique.name;
  }
}

TEST_F(FillTest, GapsOfSamplesStayUnlessSomebodyWantsThemFilled) {
  for (const WarpDescriptor& technique : warpRegistry()) {
    if (!technique.uses.depth) continue;
    SCOPED_TRACE(technique.name);
    const WarpedImage left = draw(technique.name, Fill::automatic), none = draw(technique.name, Fill::none);
    EXPECT_EQ(left.samples, none.samples);
    EXPECT_EQ(left.color, none.color);
    const HoleCount holes = countHoles(none, reference_);
    ASSERT_GT(holes.fraction(), 0.02);
    EXPECT_EQ(holes.filled, 0u);
    double before = psnrSrgb(none.color, reference_, glm::vec3(0.0f));
    for (const Fill fill : {Fill::pullPush, Fill::proxy}) {
      const WarpedImage filled = draw(technique.name, fill);
      const HoleCount count = countHoles(filled, reference_);
      EXPECT_LT(count.fraction(), fill == Fill::proxy ? 0.02 : holes.fraction());
      EXPECT_GT(count.filled, 0u);
      EXPECT_LE(count.holes + count.filled, holes.holes);
      size_t changed = 0;
      for (size_t i = 0; i < none.samples.size(); ++i) {
        if (none.samples[i] != kNoSample) {
          ASSERT_EQ(filled.samples[i], none.samples[i]);
          ASSERT_EQ(filled.color[i], none.color[i]);
        } else if (filled.samples[i] == kNoSample) {
          ASSERT_EQ(filled.color[i], glm::vec4(0.0f));
        } else {
          ASSERT_EQ(filled.samples[i], kFilled);
          ++changed;
        }
      }
      EXPECT_GE(changed, count.filled);  // beside the volume as well
      if (technique.name == "spheres") {
        const double now = psnrSrgb(filled.color, reference_, glm::vec3(0.0f));
        EXPECT_GT(now, before) << static_cast<int>(fill);
        before = now;
      }
    }
  }
}

TEST_F(FillTest, SegmentsGoOnThroughTheCopyUnlessTheyAreToldNotTo) {
  const WarpedImage meant = draw("segments", Fill::automatic), proxy = draw("segments", Fill::proxy), none = draw("segments", Fill::none);
  EXPECT_EQ(meant.samples, proxy.samples);
  EXPECT_EQ(meant.color, proxy.color);
  EXPECT_EQ(std::count(none.samples.begin(), none.samples.end(), kFilled), 0);
  EXPECT_GT(std::count(meant.samples.begin(), meant.samples.end(), kFilled), 0);
  auto bare = std::make_shared<SampleFrame>(*frame_);
  bare->proxy.reset();
  EXPECT_EQ(stage_.draw("segments", bare, camera_, filledBy(Fill::proxy)).color, none.color) << "there is no copy";
}

TEST_F(FillTest, TheCopyAloneIsWhatEveryGapShows) {
  const WarpedImage copy = stage_.draw("proxy", frame_, camera_), filled = draw("spheres", Fill::proxy), none = draw("spheres", Fill::none);
  for (size_t i = 0; i < none.samples.size(); ++i) {
    if (none.samples[i] != kNoSample) continue;
    ASSERT_EQ(filled.color[i], copy.color[i]);
    ASSERT_EQ(filled.samples[i] == kFilled, copy.samples[i] == kNotASample);
  }
  EXPECT_GT(psnrSrgb(copy.color, reference_, glm::vec3(0.0f)), 24.0);
  EXPECT_LT(countHoles(copy, reference_).fraction(), 0.02);
}

TEST_F(FillTest, FramesHaveTheCopyOnlyWhereSomebodyDrawsIt) {
  MarchSettings asked;
  asked.sample.segments = 4;
  asked.sample.proxy = 32;
  const auto proxyFor = [&](std::string_view technique, Fill fill) {
    return neededBy(std::array{TechniqueInUse{&findWarp(technique), filledBy(fill).knobs}}, asked).sample.proxy;
  };
  EXPECT_EQ(proxyFor("spheres", Fill::automatic), 0);
  EXPECT_EQ(proxyFor("spheres", Fill::pullPush), 0);
  EXPECT_EQ(proxyFor("spheres", Fill::proxy), 32);
  EXPECT_EQ(proxyFor("segments", Fill::automatic), 32);
  EXPECT_EQ(proxyFor("segments", Fill::none), 0);
  EXPECT_EQ(proxyFor("proxy", Fill::none), 32);
  EXPECT_EQ(proxyFor("hold", Fill::proxy), 0);
  const FrameBytes bytes{.samples = 400, .segments = 600, .proxy = 50};
  EXPECT_EQ(bytesFor(findWarp("proxy"), bytes), 0u);
  EXPECT_EQ(bytesFor(findWarp("segments"), bytes), 600u);
  EXPECT_EQ(bytesFor(findWarp("mesh"), bytes), 400u);
  EXPECT_TRUE(drawsPictureAlone(findWarp("hold")) && drawsPictureAlone(findWarp("rotate")));
  EXPECT_FALSE(drawsPictureAlone(findWarp("proxy")) || drawsPictureAlone(findWarp("reference")) || drawsPictureAlone(findWarp("points")));
}

TEST_F(FillTest, MarksShowWhatIsGuessedAndWhatIsNot) {
  const WarpedImage image = draw("spheres", Fill::proxy);
  const PixelMarks marks{.uncovered = 0x000000ffu, .filled = 0x0000ff00u};
  const Image<Rgba8> marked = toScreen(image, glm::vec3(0.1f), marks), plain = toScreen(image, glm::vec3(0.1f));
  for (size_t i = 0; i < marked.size(); ++i)
    ASSERT_EQ(marked[i], image.samples[i] == kNoSample ? 0xff0000ffu : image.samples[i] == kFilled ? 0xff00ff00u : plain[i]);
}

/// A frame may say that its volume is anywhere, and the copy that comes with it somewhere else.
TEST_F(FillTest, AFrameInAnotherUnitThanItsCopyIsDrawnInTime) {
  auto other = std::make_shared<SampleFrame>(*frame_);
  other->quantization.bounds = {glm::vec3(-1e9f), glm::vec3(1e9f)};
  for (const char* technique : {"segments", "proxy"}) {
    const WarpedImage image = stage_.draw(technique, other, camera_);
    EXPECT_EQ(image.color.width(), 120u);
  }
}

}  // namespace
}  // namespace warpscope
