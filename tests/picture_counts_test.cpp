// A panel's worker does what its plan says, so often and no more, and shows what it says: on its own thread, with a
// technique that counts by itself. Mirrors WarpCounts of app/session/warp_worker.h; the plan's rules are in
// picture_plan_test.cpp.
#include <gtest/gtest.h>

#include <atomic>
#include <memory>
#include <optional>
#include <semaphore>

#include "app/frames/backend.h"
#include "app/picture/picture.h"
#include "app/session/warp_worker.h"
#include "render/march/own_picture.h"
#include "render/warp/arithmetic_knob.h"
#include "render/warp/points_warp.h"
#include "render/warp/rotated_picture.h"
#include "tests/headless.h"
#include "tests/marcher_cases.h"
#include "tests/moved_cameras.h"

namespace warpscope {
namespace {

/// What the technique below was asked for, by all that were made of it.
struct Calls {
  std::atomic<uint64_t> made = 0, builds = 0, draws = 0;
  std::atomic<bool> isOnDevice = false;  // it draws for screens as if on a device
};
Calls& calls() {
  static Calls all;
  return all;
}

/// Stands for one on a device.
class FarPicture final : public DevicePicture {
 public:
  explicit FarPicture(const Camera& camera) : width_(camera.width), height_(camera.height) {}
  uint32_t width() const override { return width_; }
  uint32_t height() const override { return height_; }
  void download(std::span<Rgba8>) const override {}  // nobody looks

 private:
  const uint32_t width_, height_;
};

/// Splats, counted.
class CountedWarp final : public Warp {
 public:
  explicit CountedWarp(const WarpResources& resources) : warp_(makeWarp(findWarp("splats"), resources)) {
    ++calls().made;
  }

  void setFrame(SampleFramePtr frame, const WarpSettings& settings, const std::stop_token& stop) override {
    ++calls().builds;
    warp_->setFrame(std::move(frame), settings, stop);
  }
  void draw(const Camera& camera, const WarpSettings& settings, WarpedImage& image,
            const std::stop_token& stop) override {
    ++calls().draws;
    warp_->draw(camera, settings, image, stop);
  }
  DevicePicturePtr drawForScreen(const Camera& camera, const WarpSettings&, const glm::vec3&, const PixelMarks&,
                                 const std::stop_token&) override {
    if (!calls().isOnDevice) return nullptr;
    ++calls().draws;
    return std::make_shared<const FarPicture>(camera);
  }

 private:
  const std::unique_ptr<Warp> warp_;
};

constexpr const Knob* kCountedKnobs[] = {&kPointSizeKnob, &kArithmeticKnob};  // one that redraws, one that builds anew
constexpr WarpDescriptor kCounted{
    .name = "counted",
    .label = "Counted",
    .summary = "splats, counted",
    .knobs = kCountedKnobs,
    .make = [](const WarpResources& resources) -> std::unique_ptr<Warp> {
      return std::make_unique<CountedWarp>(resources);
    },
};

/// The worker itself, on its thread.
class PictureCounts : public testing::Test {
 protected:
  PictureCounts() {
    calls().made = calls().builds = calls().draws = 0;
    calls().isOnDevice = false;
    job_.technique = &kCounted;
    job_.marcher = marcher_;
    job_.frame = stage_.frame(home_, stage_.scene().march);
    job_.camera = home_;
    job_.camera.eye.x += 2.0f;
  }

  WarpResult paint(const WarpJob& job) {
    worker_->post(job);
    news_.acquire();
    std::optional<WarpResult> result = worker_->tryTake();
    if (!result) return {};
    EXPECT_EQ(result->error, "");
    EXPECT_TRUE(result->picture);
    EXPECT_EQ(result->counts.made, calls().made);
    EXPECT_EQ(result->counts.builds, calls().builds);
    EXPECT_EQ(result->counts.draws + result->counts.drawsToJudge, calls().draws);
    return *result;
  }
  std::shared_ptr<const ReferenceImage> referenceAt(const Camera& camera) const {
    Image<glm::vec4> color;
    marcher_->twin()->render(camera, stage_.scene().march.render, color);
    return std::make_shared<const ReferenceImage>(ReferenceJob{marcher_, camera, stage_.scene().march.render, {}},
                                                  std::move(color));
  }

  Stage stage_{smallScene("block", 32)};
  const Camera home_ = stage_.camera(40, 56);
  const MarcherPtr marcher_ = makeMarcher(Backend::cpu, stage_.scene().volume, stage_.scene().transferFunction);
  WarpJob job_;
  std::counting_semaphore<> news_{0};
  const std::unique_ptr<WarpWorker> worker_ =
      makeWarpWorker(gl::Platform::automatic, {.marcher = {}, .context = {}, .backend = Backend::cpu, .onFallback = {}},
                     [this] { news_.release(); });
};

TEST_F(PictureCounts, WhereNothingMovesNothingIsDone) {
  const WarpResult first = paint(job_);
  EXPECT_EQ(first.counts, (WarpCounts{.made = 1, .builds = 1, .draws = 1}));
  for (int i = 0; i < 5; ++i) {
    const WarpResult again = paint(job_);
    EXPECT_EQ(again.counts, first.counts);
    EXPECT_EQ(again.picture, first.picture) << "the very same";
  }
}

TEST_F(PictureCounts, AnUnchangedFrameIsBuiltOnceAndDrawnForEachCamera) {
  for (int i = 0; i < 10; ++i) {
    job_.camera.eye.y += 1.0f;
    paint(job_);
  }
  EXPECT_EQ(paint(job_).counts, (WarpCounts{.made = 1, .builds = 1, .draws = 10}));
  job_.frame = stage_.frame(home_, stage_.scene().march);
  EXPECT_EQ(paint(job_).counts, (WarpCounts{.made = 1, .builds = 2, .draws = 11}));
}

TEST_F(PictureCounts, KnobsDoNoMoreThanTheyMakeStale) {
  paint(job_);
  job_.settings.knobs.set(kPointSizeKnob, 5);
  EXPECT_EQ(paint(job_).counts, (WarpCounts{.made = 1, .builds = 1, .draws = 2})) << "redrawn";
  job_.settings.knobs.set(kArithmeticKnob, Arithmetic::textbook);
  EXPECT_EQ(paint(job_).counts, (WarpCounts{.made = 1, .builds = 2, .draws = 3})) << "built anew";
  job_.background = glm::vec3(0.5f);
  const WarpResult lighter = paint(job_);
  EXPECT_EQ(lighter.counts, (WarpCounts{.made = 1, .builds = 2, .draws = 3})) << "put over another colour";
  EXPECT_TRUE(lighter.plan.has(PictureStage::toScreen));
}

TEST_F(PictureCounts, TheOwnCameraTakesNoTechniqueUntilItIsLeft) {
  job_.takesShortcuts = true;
  const Camera elsewhere = job_.camera;
  job_.camera = home_;
  const WarpResult own = paint(job_);
  EXPECT_EQ(own.counts, (WarpCounts{.shortcuts = 1}));
  EXPECT_EQ(own.plan.way(), PictureWay::ownPicture);
  EXPECT_EQ(own.buildMs, 0.0);
  job_.settings.knobs.set(kArithmeticKnob, Arithmetic::textbook);
  EXPECT_EQ(paint(job_).counts, own.counts) << "the knob is a technique's";
  job_.camera = elsewhere;
  EXPECT_EQ(paint(job_).counts, (WarpCounts{.made = 1, .builds = 1, .draws = 1, .shortcuts = 1}));
  job_.camera = home_;
  const WarpResult back = paint(job_);
  EXPECT_EQ(back.counts, (WarpCounts{.made = 1, .builds = 1, .draws = 1, .shortcuts = 2}));
  EXPECT_EQ(back.buildMs, 0.0) << "what is on show was not built";
  job_.camera = elsewhere;
  EXPECT_EQ(paint(job_).counts, (WarpCounts{.made = 1, .builds = 1, .draws = 2, .shortcuts = 2}))
      << "what was built is still there";
  EXPECT_GT(paint(job_).buildMs, 0.0);
}

TEST_F(PictureCounts, TheOwnCameraShowsTheFramesPictureBitForBit) {
  Image<glm::vec4> color;
  const Image<uint32_t> rays = ownPicture(*job_.frame);
  resolveRayColors(*job_.frame, rays, color);
  job_.takesShortcuts = true;
  job_.camera = home_;
  job_.reference = referenceAt(home_);
  const WarpResult own = paint(job_);
  ASSERT_TRUE(own.judged);
  EXPECT_TRUE(sameBits(own.judged->color, color));
  EXPECT_TRUE(own.judged->samples == rays);
  // Pictures that were handed out stay as they are, whatever is drawn next.
  job_.camera = turned(home_, 5.0f);
  job_.reference = referenceAt(job_.camera);
  const WarpResult rotated = paint(job_);
  ASSERT_TRUE(rotated.judged);
  EXPECT_FALSE(sameBits(rotated.judged->color, color));
  const WarpedImage kept = *rotated.judged;
  job_.camera = turned(home_, 9.0f);
  job_.reference.reset();
  paint(job_);
  job_.camera.eye.x += 2.0f;
  paint(job_);
  EXPECT_TRUE(sameBits(own.judged->color, color));
  EXPECT_TRUE(sameBits(rotated.judged->color, kept.color));
}

/// What is kept of a frame to be turned is that frame's, and stays as it is while it is on show and while it is turned.
TEST_F(PictureCounts, ATurnIsOfTheFrameAtHand) {
  job_.takesShortcuts = true;
  for (const float turnDeg : {0.0f, 20.0f}) {
    const Camera home = stage_.camera(40, 56, turnDeg);
    job_.frame = stage_.frame(home, stage_.scene().march);
    for (const Camera& camera : {home, turned(home, 3.0f), home, turned(home, -4.0f)}) {
      job_.camera = camera;
      WarpedImage expected;
      drawRotated(ownImageOf(*job_.frame), home, camera, expected);
      const WarpResult result = paint(job_);
      ASSERT_TRUE(result.picture.host);
      EXPECT_TRUE(*result.picture.host == toScreen(expected, job_.background)) << turnDeg;
    }
  }
}

TEST_F(PictureCounts, ATurnTakesNoTechnique) {
  job_.takesShortcuts = true;
  uint64_t shortcuts = 0;
  for (const Camera& camera : {turned(home_, 3.0f), zoomed(home_), ofSize(home_, 64, 48)}) {
    job_.camera = camera;
    const WarpResult result = paint(job_);
    EXPECT_EQ(result.counts, (WarpCounts{.shortcuts = ++shortcuts}));
    EXPECT_EQ(result.plan.way(), PictureWay::rotation);
    EXPECT_EQ(result.picture.width(), camera.width);
    EXPECT_EQ(result.picture.height(), camera.height);
  }
  job_.takesShortcuts = false;
  EXPECT_EQ(paint(job_).counts, (WarpCounts{.made = 1, .builds = 1, .draws = 1, .shortcuts = shortcuts}));
}

TEST_F(PictureCounts, JudgingDrawsOnlyForAnEarlierCamera) {
  paint(job_);
  job_.reference = referenceAt(job_.camera);
  WarpResult result = paint(job_);
  EXPECT_TRUE(result.judged);
  EXPECT_EQ(result.counts, (WarpCounts{.made = 1, .builds = 1, .draws = 1}));
  job_.camera.eye.y += 1.0f;
  result = paint(job_);
  EXPECT_FALSE(result.judged) << "the ground truth is not new";
  EXPECT_EQ(result.counts, (WarpCounts{.made = 1, .builds = 1, .draws = 2}));
  job_.reference = referenceAt(turned(job_.camera, 2.0f));
  result = paint(job_);
  EXPECT_TRUE(result.judged);
  EXPECT_EQ(result.counts, (WarpCounts{.made = 1, .builds = 1, .draws = 2, .drawsToJudge = 1}));
  // At the own camera no technique is made to judge what an earlier camera saw.
  job_.takesShortcuts = true;
  job_.camera = home_;
  job_.reference = referenceAt(turned(job_.camera, 3.0f));
  result = paint(job_);
  EXPECT_FALSE(result.judged);
  EXPECT_EQ(result.counts, (WarpCounts{.made = 1, .builds = 1, .draws = 2, .drawsToJudge = 1, .shortcuts = 1}));
}

/// A device puts colours over their background as it draws, and judging wants them in the host's memory.
TEST_F(PictureCounts, ADeviceDrawsForTheScreenAndOnceMoreToBeJudged) {
  calls().isOnDevice = true;
  const WarpResult first = paint(job_);
  EXPECT_TRUE(first.picture.device);
  EXPECT_EQ(first.counts, (WarpCounts{.made = 1, .builds = 1, .draws = 1}));
  EXPECT_EQ(paint(job_).picture, first.picture);
  job_.reference = referenceAt(job_.camera);
  for (int i = 0; i < 2; ++i) {
    const WarpResult judged = paint(job_);
    EXPECT_TRUE(judged.judged);
    EXPECT_EQ(judged.picture, first.picture);
    EXPECT_EQ(judged.counts, (WarpCounts{.made = 1, .builds = 1, .draws = 1, .drawsToJudge = 1})) << "once";
  }
  job_.reference.reset();
  job_.background = glm::vec3(0.5f);
  EXPECT_EQ(paint(job_).counts, (WarpCounts{.made = 1, .builds = 1, .draws = 2, .drawsToJudge = 1}));
  job_.takesShortcuts = true;
  job_.camera = home_;
  const WarpResult own = paint(job_);
  EXPECT_FALSE(own.picture.device);
  EXPECT_EQ(own.counts, (WarpCounts{.made = 1, .builds = 1, .draws = 2, .drawsToJudge = 1, .shortcuts = 1}));
}

TEST_F(PictureCounts, TimingAPictureIsNotCountedAndAShortcutIsNotTimed) {
  paint(job_);
  WarpJob timed = job_;
  timed.timedAs = CodecSettings{};
  const auto post = [&] {
    worker_->post(timed);
    news_.acquire();
    return *worker_->tryTake();
  };
  WarpResult result = post();
  EXPECT_TRUE(result.timed);
  EXPECT_EQ(result.counts, (WarpCounts{.made = 1, .builds = 1, .draws = 1}));
  EXPECT_GT(calls().draws, 1u) << "nothing was timed: this test shows nothing";
  timed.takesShortcuts = true;
  timed.camera = home_;
  timed.timedAs.reset();
  worker_->post(timed);
  news_.acquire();
  ASSERT_EQ(worker_->tryTake()->plan.way(), PictureWay::ownPicture);
  timed.timedAs = CodecSettings{};
  EXPECT_FALSE(post().timed);
}

TEST_F(PictureCounts, BeginAnewWithAnotherScene) {
  paint(job_);
  WarpJob other = job_;
  other.scene = job_.scene + 1;
  other.marcher = marcher_->twin();
  worker_->post(other);
  news_.acquire();
  EXPECT_EQ(worker_->tryTake()->counts, (WarpCounts{.made = 1, .builds = 1, .draws = 1}));
  // Where a shortcut takes its place, what was made for the other volume goes all the same.
  std::weak_ptr<Marcher> held = other.marcher;
  other.marcher.reset();
  job_.takesShortcuts = true;
  job_.camera = home_;
  worker_->post(job_);
  news_.acquire();
  EXPECT_EQ(worker_->tryTake()->counts, (WarpCounts{.shortcuts = 1}));
  EXPECT_TRUE(held.expired());
}

}  // namespace
}  // namespace warpscope
