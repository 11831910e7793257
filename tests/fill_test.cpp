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

TEST_F(FillTest, InTheFramesOwnViewNothingIsMissing) {
  for (const WarpDescriptor& technique : warpRegistry()) {
    if (!leavesGaps(technique)) continue;
    SCOPED_TRACE(technique.name);
    const WarpedImage own = stage_.draw(technique.name, frame_, frame_->camera, filledBy(Fill::none));
    ASSERT_GT(std::count(own.samples.begin(), own.samples.end(), kNoSample), 0) << "background";
    for (const Fill fill : {Fill::pullPush, Fill::proxy}) {
      if (fill == Fill::proxy && technique.uses.proxy) continue;  // goes on behind the ends of rays
      const WarpedImage filled = stage_.draw(technique.name, frame_, frame_->camera, filledBy(fill));
      EXPECT_EQ(filled.samples, own.samples) << static_cast<int>(fill);
      EXPECT_EQ(filled.color, own.color) << static_cast<int>(fill);
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

TEST_F(FillTest, OfGreatestValuesTheCopysIsShownWhereItIsGreater) {
  MarchSettings march = frame_->settings;
  march.render.effects.mode = RenderMode::mip;
  Camera narrow = stage_.camera(120, 90);
  narrow.tanHalfFovY *= 0.4f;  // rays that meet segments of its frame begin and go on where it knows nothing
  for (const Camera& server : {stage_.camera(120, 90), narrow}) {
    const SampleFramePtr frame = stage_.frame(server, march);
    const WarpedImage copy = stage_.draw("proxy", frame, camera_);
    for (const char* technique : {"segments", "spheres"}) {
      SCOPED_TRACE(std::string(technique) + (server == narrow ? " of a narrow frame" : ""));
      const WarpedImage none = stage_.draw(technique, frame, camera_, filledBy(Fill::none)), filled = stage_.draw(technique, frame, camera_, filledBy(Fill::proxy));
      size_t gaps = 0, exceeded = 0, kept = 0;
      for (size_t i = 0; i < none.samples.size(); ++i) {
        const bool isGap = none.samples[i] == kNoSample, isGreater = copy.color[i].a > none.color[i].a;
        gaps += isGap && isGreater ? 1 : 0;
        exceeded += !isGap && isGreater ? 1 : 0;
        kept += !isGap && !isGreater ? 1 : 0;
        ASSERT_EQ(filled.samples[i], isGreater ? kFilled : none.samples[i]);
        ASSERT_EQ(filled.color[i], isGreater ? copy.color[i] : none.color[i]);
      }
      EXPECT_GT(gaps, 0u);
      EXPECT_GT(exceeded, 0u);
      EXPECT_GT(kept, 0u);
      if (technique == std::string_view("segments")) EXPECT_EQ(stage_.draw(technique, frame, camera_).color, filled.color);
    }
  }
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

/// A frame may say that its volume is anywhere, and the copy that comes with it somewhere else: rays are marched through the copy alone, as is seen at what
/// they show.
TEST_F(FillTest, AFrameInAnotherUnitThanItsCopyIsMarchedThroughTheCopyAlone) {
  auto other = std::make_shared<SampleFrame>(*frame_);
  other->quantization.bounds = {glm::vec3(-1e9f), glm::vec3(1e9f)};
  EXPECT_EQ(stage_.draw("proxy", other, camera_).color, stage_.draw("proxy", frame_, camera_).color);
  const WarpedImage image = stage_.draw("segments", other, camera_);
  EXPECT_GT(std::count(image.samples.begin(), image.samples.end(), kFilled), 100) << "beside the frame's view";
  for (const glm::vec4& color : image.color) ASSERT_TRUE(color.a >= 0.0f && color.a <= 1.0f);
}

/// The copy in full size is the volume: its picture is the volume's in every mode and however that is cut, but for voxels' 8 bits.
TEST(CopyOfAVolume, IsMarchedAsTheVolumeIs) {
  const Stage stage(smallScene("shells", 48));
  const auto expectTheVolumes = [&](const char* what, const auto& change) {
    MarchSettings march = stage.scene().march;
    march.sample.segments = 4;
    march.sample.proxy = 48;
    change(march.render.effects);
    const SampleFramePtr frame = stage.frame(stage.camera(96, 96), march);
    const Camera camera = stage.camera(96, 96, 40.0);
    Image<glm::vec4> reference;
    stage.marcher().render(camera, march.render, reference);
    const WarpedImage copy = stage.draw("proxy", frame, camera), none = stage.draw("spheres", frame, camera, filledBy(Fill::none)),
                      filled = stage.draw("spheres", frame, camera, filledBy(Fill::proxy));
    EXPECT_GT(psnrSrgb(copy.color, reference, glm::vec3(0.0f)), 40.0) << what;
    EXPECT_GE(psnrSrgb(filled.color, reference, glm::vec3(0.0f)), psnrSrgb(none.color, reference, glm::vec3(0.0f))) << what;
    return reference;
  };
  const Image<glm::vec4> whole = expectTheVolumes("whole", [](Effects&) {});
  const auto isAnother = [&](const Image<glm::vec4>& other) { return psnrSrgb(other, whole, glm::vec3(0.0f)) < 35.0; };
  EXPECT_TRUE(isAnother(expectTheVolumes("a box", [](Effects& effects) { effects.clip.box = parseClipBox("0,0,0,0.5,1,1", "it"); })));
  EXPECT_TRUE(isAnother(expectTheVolumes("a plane", [](Effects& effects) { effects.clip.planes = parseClipPlanes("1,0,0,0", "it"); })));
  EXPECT_TRUE(isAnother(expectTheVolumes("greatest values", [](Effects& effects) { effects.mode = RenderMode::mip; })));
  EXPECT_TRUE(isAnother(expectTheVolumes("surfaces", [](Effects& effects) {
    effects.mode = RenderMode::isosurface;
    effects.isoValues = parseIsoValues("60 120@0.5", "it");
  })));
}

TEST(CopyOfAVolume, ThatIsMissingIsToldWhereGapsAreToBeFilledWithIt) {
  MarchSettings march;
  march.sample.segments = 4;
  EXPECT_EQ(lackOf(findWarp("spheres"), march), "");
  EXPECT_EQ(lackOf(findWarp("segments"), march), "");
  EXPECT_NE(lackOf(findWarp("spheres"), march, filledBy(Fill::proxy).knobs), "");
  EXPECT_NE(lackOf(findWarp("segments"), march, filledBy(Fill::proxy).knobs), "");
  EXPECT_NE(lackOf(findWarp("proxy"), march), "");
  EXPECT_EQ(lackOf(findWarp("hold"), march, filledBy(Fill::proxy).knobs), "");
  march.sample.proxy = 8;
  EXPECT_EQ(lackOf(findWarp("spheres"), march, filledBy(Fill::proxy).knobs), "");
}

}  // namespace
}  // namespace warpscope
