// Frames that are kept: which stay and for how long, and what they add to pictures.
// Mirrors render/warp/kept_frames.h, and render/warp/completed_warp.h where it uses them.
#include <gtest/gtest.h>

#include "render/metrics/holes.h"
#include "render/metrics/psnr.h"
#include "render/warp/completed_warp.h"
#include "render/warp/fill.h"
#include "render/warp/kept_frames.h"
#include "render/warp/mesh_warp.h"
#include "warp_cases.h"

namespace warpscope {
namespace {

WarpSettings keeping(int frames, Fill fill = Fill::none) {
  WarpSettings settings;
  settings.knobs.set(kKeepKnob, frames);
  settings.knobs.set(kFillKnob, fill);
  return settings;
}

class KeptFramesTest : public testing::Test {
 protected:
  KeptFramesTest() : stage_(smallScene("block", 64)) {
    march_ = stage_.scene().march;
    march_.sample.segments = 2;
    march_.sample.proxy = 0;
  }

  SampleFramePtr frameAt(double turnDeg) const { return stage_.frame(stage_.camera(120, 90, turnDeg), march_); }

  /// What a technique that is handed those frames shows at an angle.
  WarpedImage draw(std::string_view technique, const std::vector<SampleFramePtr>& frames, double turnDeg, const WarpSettings& settings) const {
    const std::unique_ptr<Warp> warp = makeWarp(findWarp(technique), stage_.resources());
    for (const SampleFramePtr& frame : frames) warp->setFrame(frame, settings);
    WarpedImage image;
    warp->draw(stage_.camera(120, 90, turnDeg), settings, image);
    return image;
  }

  Stage stage_;
  MarchSettings march_;
};

TEST_F(KeptFramesTest, WhatWasSeenBeforeNeedsNoGuess) {
  const std::vector<SampleFramePtr> frames{frameAt(0.0), frameAt(30.0), frameAt(60.0)};
  Image<glm::vec4> reference;
  stage_.marcher().render(stage_.camera(120, 90, 20.0), march_.render, reference);
  for (const WarpDescriptor& technique : warpRegistry()) {
    if (!technique.has(kKeepKnob)) continue;
    SCOPED_TRACE(technique.name);
    const WarpedImage alone = draw(technique.name, {frames.back()}, 20.0, keeping(8));
    const WarpedImage newest = draw(technique.name, frames, 20.0, keeping(1)), kept = draw(technique.name, frames, 20.0, keeping(3));
    EXPECT_EQ(newest.samples, alone.samples) << "nothing is kept unless somebody wants that";
    EXPECT_EQ(newest.color, alone.color);
    const HoleCount before = countHoles(alone, reference), now = countHoles(kept, reference);
    ASSERT_GT(before.fraction(), 0.02);
    EXPECT_LT(now.fraction(), 0.4 * before.fraction());
    EXPECT_GT(psnrSrgb(kept.color, reference, glm::vec3(0.0f)), psnrSrgb(alone.color, reference, glm::vec3(0.0f)) + 1.0);
    // The newest frame's pixels are its own; the others are those of the newest frame before it that has any.
    const WarpedImage second = draw(technique.name, {frames[1]}, 20.0, keeping(1)), first = draw(technique.name, {frames[0]}, 20.0, keeping(1));
    for (size_t i = 0; i < kept.samples.size(); ++i) {
      const glm::vec4& expected = alone.samples[i] != kNoSample ? alone.color[i] : second.samples[i] != kNoSample ? second.color[i] : first.color[i];
      ASSERT_EQ(kept.color[i], expected) << i;
      ASSERT_EQ(framesBack(kept.samples[i]), alone.samples[i] != kNoSample ? 0u : second.samples[i] != kNoSample ? 1u : first.samples[i] != kNoSample ? 2u : 0u) << i;
      ASSERT_EQ(kept.samples[i] == alone.samples[i], alone.samples[i] != kNoSample || kept.samples[i] == kNoSample) << i;
    }
  }
}

TEST_F(KeptFramesTest, TheNewestSoManyStayAndThoseFromElsewhere) {
  const SampleFramePtr far = frameAt(-60.0), first = frameAt(0.0), near = frameAt(2.0), last = frameAt(40.0);
  const auto shows = [&](const std::vector<SampleFramePtr>& frames, int most) { return draw("spheres", frames, -40.0, keeping(most)).color; };
  EXPECT_EQ(shows({far, first, last}, 2), shows({first, last}, 2)) << "only one is kept beside the newest";
  EXPECT_NE(shows({far, first, last}, 3), shows({first, last}, 3));
  EXPECT_EQ(shows({first, near, last}, 3), shows({first, last}, 3)) << "two degrees aside: it saw nothing else";
}

TEST_F(KeptFramesTest, OtherSettingsOrAnotherVolumeClearThem) {
  const SampleFramePtr first = frameAt(0.0), last = frameAt(40.0);
  const auto shows = [&](const std::vector<SampleFramePtr>& frames) { return draw("spheres", frames, 0.0, keeping(4)).color; };
  const auto alone = shows({last});
  ASSERT_NE(shows({first, last}), alone);
  auto other = std::make_shared<SampleFrame>(*first);
  other->settings.sample.heuristic = Heuristic::entrance;
  EXPECT_EQ(shows({other, last}), alone);
  other = std::make_shared<SampleFrame>(*first);
  other->quantization.bounds.upper.x += 1.0f;
  EXPECT_EQ(shows({other, last}), alone);
  EXPECT_EQ(shows({first, nullptr, last}), alone);
  EXPECT_TRUE(KeptFrames::fit(*first, *last));
}

TEST_F(KeptFramesTest, WhatFramesDoNotHaveIsFilledAfterwards) {
  const std::vector<SampleFramePtr> frames{frameAt(0.0), frameAt(60.0)};
  const WarpedImage kept = draw("spheres", frames, 25.0, keeping(2)), filled = draw("spheres", frames, 25.0, keeping(2, Fill::pullPush));
  size_t guesses = 0;
  for (size_t i = 0; i < kept.samples.size(); ++i) {
    if (kept.samples[i] != kNoSample) {
      ASSERT_EQ(filled.color[i], kept.color[i]);
    }
    guesses += filled.samples[i] == kFilled;
  }
  EXPECT_GT(guesses, 10u);
}

TEST_F(KeptFramesTest, HowFarApartCamerasAre) {
  const Box bounds{glm::vec3(-10.0f), glm::vec3(10.0f)};
  const auto at = [](const glm::vec3& eye) {
    Camera camera;
    camera.eye = eye;
    return camera;
  };
  EXPECT_NEAR(apartDeg(at({0, 0, 30}), at({0, 30, 0}), bounds), 90.0, 1e-9);
  EXPECT_NEAR(apartDeg(at({0, 0, 30}), at({0, 0, 30}), bounds), 0.0, 1e-9);
  EXPECT_NEAR(apartDeg(at({0, 0, 30}), at({0, 0, -30}), bounds), 180.0, 1e-9);
  EXPECT_GT(apartDeg(at({0, 0, 30}), at({0, 0, 33}), bounds), kKeptApartDeg) << "a tenth nearer";
  EXPECT_EQ(apartDeg(at({0, 0, 0}), at({0, 0, 0}), bounds), 0.0);
  EXPECT_EQ(apartDeg(at({0, 0, 0}), at({0, 0, 1}), bounds), 180.0);
}

TEST_F(KeptFramesTest, FewerStayFromTheFrameOnWithWhichTheyAreWanted) {
  const std::vector<SampleFramePtr> frames{frameAt(-40.0), frameAt(-20.0), frameAt(0.0), frameAt(20.0)};
  const SampleFramePtr near = frameAt(22.0);
  const auto shows = [&](bool isTurnedBefore) {
    const std::unique_ptr<Warp> warp = makeWarp(findWarp("spheres"), stage_.resources());
    for (const SampleFramePtr& frame : frames) warp->setFrame(frame, keeping(8));
    if (isTurnedBefore) warp->setFrame(frames.back(), keeping(2));
    warp->setFrame(near, keeping(2));
    WarpedImage image;
    warp->draw(stage_.camera(120, 90, -30.0), keeping(2), image);
    return image;
  };
  const WarpedImage before = shows(true), together = shows(false);
  EXPECT_EQ(together.samples, before.samples);
  EXPECT_EQ(together.color, before.color);
}

TEST_F(KeptFramesTest, AreBuiltByKnobsThatCameWithAnotherFrame) {
  const SampleFramePtr first = frameAt(0.0), last = frameAt(30.0);
  const auto cutAt = [](double cut) {
    WarpSettings settings = keeping(2);
    settings.knobs.set(kMeshCutKnob, cut);
    return settings;
  };
  const auto shows = [&](double cutOfFirst) {
    const std::unique_ptr<Warp> warp = makeWarp(findWarp("mesh"), stage_.resources());
    warp->setFrame(first, cutAt(cutOfFirst));
    warp->setFrame(last, cutAt(5.0));
    WarpedImage image;
    warp->draw(stage_.camera(120, 90, 20.0), cutAt(5.0), image);
    return image;
  };
  EXPECT_EQ(shows(0.05).samples, shows(5.0).samples);
}

/// Counts frames that it is given.
class CountingWarp final : public Warp {
 public:
  explicit CountingWarp(size_t& built) : built_(built) {}
  void setFrame(SampleFramePtr, const WarpSettings&, const std::stop_token&) override { ++built_; }
  void draw(const Camera& camera, const WarpSettings&, WarpedImage& image, const std::stop_token&) override {
    image.samples.resize(camera.width, camera.height, kNoSample);
    image.color.resize(camera.width, camera.height);
  }

 private:
  size_t& built_;
};

TEST_F(KeptFramesTest, HowManyThereAreChangesNoneOfThem) {
  size_t built = 0;
  const std::unique_ptr<Warp> warp = makeCompletedWarp(findWarp("spheres"), [&] { return std::make_unique<CountingWarp>(built); });
  SampleFramePtr newest;
  for (const double turnDeg : {0.0, 10.0, 20.0, 30.0}) warp->setFrame(newest = frameAt(turnDeg), keeping(8));
  EXPECT_EQ(built, 4u);
  warp->setFrame(newest, keeping(7));
  EXPECT_EQ(built, 5u) << "the newest alone";
}

}  // namespace
}  // namespace warpscope
