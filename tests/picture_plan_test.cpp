// Each stage of a panel's picture is in where it is needed and out where it is not, and the worker does what the plan says, so often and no more.
// Mirrors app/session/picture_plan.h; the counts are of app/session/warp_worker.h, and of a technique that counts by itself.
#include "app/session/picture_plan.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <cmath>
#include <semaphore>

#include "app/frames/backend.h"
#include "app/session/warp_worker.h"
#include "render/march/own_picture.h"
#include "render/warp/arithmetic_knob.h"
#include "render/warp/points_warp.h"
#include "tests/headless.h"
#include "tests/marcher_cases.h"

namespace warpscope {
namespace {

Camera someCamera() { return lookingFrom({3.0f, 4.0f, 60.0f}, {}, 40, 30); }

Camera withEye(Camera camera, const glm::vec3& eye) {
  camera.eye = eye;
  return camera;
}
Camera resized(Camera camera, uint32_t width, uint32_t height) {
  camera.width = width;
  camera.height = height;
  return camera;
}
Camera zoomed(Camera camera) {
  camera.tanHalfFovY *= 0.5f;
  return camera;
}
/// About its own eye.
Camera turned(Camera camera, float degrees) {
  const float angle = glm::radians(degrees), c = std::cos(angle), s = std::sin(angle);
  const glm::vec3 right = camera.right, forward = camera.forward;
  camera.right = c * right + s * forward;
  camera.forward = c * forward - s * right;
  return camera;
}

SampleFramePtr frameOf(const Camera& camera) {
  auto frame = std::make_shared<SampleFrame>();
  frame->camera = camera;
  return frame;
}

/// What a worker has in hand once it has done that job.
EaselState after(const WarpJob& job) {
  EaselState state;
  const PictureWay way = PicturePlan({}, job).way();
  if (way == PictureWay::technique) {
    state.technique = job.technique;
    state.marcher = job.marcher;
    state.isBuilt = job.technique->usesFrame;
    state.built = job.frame;
    state.builtWith = job.settings.knobs;
  }
  state.hasPicture = true;
  state.way = way;
  state.frame = job.frame;
  state.camera = job.camera;
  state.settings = job.settings;
  state.background = job.background;
  state.uncovered = job.uncovered;
  state.reference = job.reference;
  return state;
}

std::vector<std::string_view> stagesIn(const PicturePlan& plan) {
  std::vector<std::string_view> names;
  for (const PictureStageDescriptor& stage : kPictureStages)
    if (plan.has(stage.stage)) names.push_back(stage.name);
  return names;
}

class PicturePlanTest : public testing::Test {
 protected:
  PicturePlanTest() {
    job_.technique = &findWarp("spheres");
    job_.marcher = marcher_;
    job_.frame = frameOf(someCamera());
    job_.camera = withEye(someCamera(), {9.0f, 4.0f, 60.0f});
  }

  /// The same job from the frame's own eye, with shortcuts.
  WarpJob shortcut(const Camera& camera) const {
    WarpJob job = job_;
    job.takesShortcuts = true;
    job.camera = camera;
    return job;
  }
  std::shared_ptr<const ReferenceImage> referenceAt(const Camera& camera) const {
    return std::make_shared<const ReferenceImage>(ReferenceJob{marcher_, camera, {}, {}}, Image<glm::vec4>(camera.width, camera.height));
  }
  MarcherPtr anotherMarcher() const { return marcher_->twin(); }

  const Scene scene_ = smallScene("block", 16);
  const MarcherPtr marcher_ = makeMarcher(Backend::cpu, scene_.volume, scene_.transferFunction);
  WarpJob job_;
};

TEST_F(PicturePlanTest, EveryStageHasAReason) {
  WarpJob alone = job_;
  alone.technique = &findWarp("reference");
  alone.frame.reset();
  for (const WarpJob& job : {job_, alone, shortcut(someCamera()), shortcut(turned(someCamera(), 3.0f))})
    for (const EaselState& last : {EaselState{}, after(job), after(job_)})
      for (const PictureStageDescriptor& stage : kPictureStages) EXPECT_FALSE(PicturePlan(last, job)[stage.stage].reason.empty()) << stage.name;
  for (size_t i = 0; i < kPictureStages.size(); ++i) EXPECT_EQ(static_cast<size_t>(kPictureStages[i].stage), i);
}

TEST_F(PicturePlanTest, TheFirstPictureTakesEverythingAndThenNothingMoves) {
  EXPECT_THAT(stagesIn({{}, job_}), testing::ElementsAre("technique", "build", "draw", "to-screen"));
  EXPECT_THAT(stagesIn({after(job_), job_}), testing::IsEmpty());
}

TEST_F(PicturePlanTest, TheFramesOwnCameraTakesItsPictureAlone) {
  const WarpJob job = shortcut(someCamera());
  const PicturePlan plan({}, job);
  EXPECT_EQ(plan.way(), PictureWay::ownPicture);
  EXPECT_THAT(stagesIn(plan), testing::ElementsAre("own-picture", "to-screen"));
  EXPECT_THAT(stagesIn({after(job), job}), testing::IsEmpty()) << "it is on show";
  WarpJob next = job;
  next.frame = frameOf(someCamera());
  EXPECT_THAT(stagesIn({after(job), next}), testing::ElementsAre("own-picture", "to-screen")) << "another frame";
  EXPECT_THAT(stagesIn({after(job_), job}), testing::ElementsAre("own-picture", "to-screen")) << "the technique drew what is on show";
  EXPECT_THAT(stagesIn({after(shortcut(zoomed(someCamera()))), job}), testing::ElementsAre("own-picture", "to-screen"));
  for (const Camera& other : {resized(someCamera(), 41, 30), zoomed(someCamera()), turned(someCamera(), 1.0f), withEye(someCamera(), {3.0f, 4.0f, 61.0f})}) {
    EXPECT_FALSE(PicturePlan({}, shortcut(other)).has(PictureStage::ownPicture));
    EXPECT_EQ(PicturePlan({}, shortcut(other))[PictureStage::ownPicture].reason, "the camera is not the frame's");
  }
}

TEST_F(PicturePlanTest, TheFramesEyeTakesNoDepth) {
  for (const Camera& camera : {resized(someCamera(), 41, 30), zoomed(someCamera()), turned(someCamera(), 1.0f)}) {
    const WarpJob job = shortcut(camera);
    const PicturePlan plan({}, job);
    EXPECT_EQ(plan.way(), PictureWay::rotation);
    EXPECT_THAT(stagesIn(plan), testing::ElementsAre("rotation", "to-screen"));
    EXPECT_THAT(stagesIn({after(job), job}), testing::IsEmpty()) << "it is on show";
    EXPECT_THAT(stagesIn({after(job_), job}), testing::ElementsAre("rotation", "to-screen")) << "the technique drew what is on show";
    EXPECT_THAT(stagesIn({after(job), shortcut(turned(camera, 1.0f))}), testing::ElementsAre("rotation", "to-screen"));
    WarpJob next = job;
    next.frame = frameOf(someCamera());
    EXPECT_THAT(stagesIn({after(job), next}), testing::ElementsAre("rotation", "to-screen")) << "another frame";
  }
  // The eye is the frame's exactly, or depth matters.
  const glm::vec3 eye = someCamera().eye;
  for (int axis = 0; axis < 3; ++axis) {
    glm::vec3 beside = eye;
    beside[axis] = std::nextafter(beside[axis], 1e9f);
    const PicturePlan plan({}, shortcut(withEye(someCamera(), beside)));
    EXPECT_EQ(plan.way(), PictureWay::technique);
    EXPECT_FALSE(plan.has(PictureStage::rotation));
    EXPECT_THAT(plan[PictureStage::rotation].reason, testing::HasSubstr("depths"));
  }
  EXPECT_FALSE(PicturePlan({}, shortcut(someCamera())).has(PictureStage::rotation));
  EXPECT_THAT(PicturePlan({}, shortcut(someCamera()))[PictureStage::rotation].reason, testing::HasSubstr("nothing is turned"));
}

TEST_F(PicturePlanTest, ShortcutsAreForFramesAndForWhoWantsThem) {
  for (const Camera& camera : {someCamera(), turned(someCamera(), 1.0f)}) {
    WarpJob off = shortcut(camera);
    off.takesShortcuts = false;
    WarpJob alone = shortcut(camera);
    alone.technique = &findWarp("reference");
    WarpJob without = shortcut(camera);
    without.frame.reset();
    const std::pair<WarpJob, const char*> cases[] = {{off, "switched off"}, {alone, "reference draws from no frame"}, {without, "there is no frame"}};
    for (const auto& [job, reason] : cases) {
      const PicturePlan plan({}, job);
      EXPECT_EQ(plan.way(), PictureWay::technique) << reason;
      EXPECT_TRUE(plan.has(PictureStage::draw)) << reason;
      for (const PictureStage stage : {PictureStage::ownPicture, PictureStage::rotation}) {
        EXPECT_FALSE(plan.has(stage)) << reason;
        EXPECT_THAT(plan[stage].reason, testing::HasSubstr(reason));
      }
    }
  }
  EXPECT_EQ(kShortcutsKnob.defaultValue, 0.0);
  EXPECT_FALSE(WarpJob{}.takesShortcuts);
}

TEST_F(PicturePlanTest, WhatTheTechniqueDrewForTheSameCameraIsNoShortcut) {
  for (const auto& [camera, name] : {std::pair(someCamera(), "own-picture"), std::pair(turned(someCamera(), 1.0f), "rotation")}) {
    const WarpJob job = shortcut(camera);
    WarpJob off = job;
    off.takesShortcuts = false;
    EXPECT_THAT(stagesIn({after(off), job}), testing::ElementsAre(name, "to-screen"));
    EaselState without = after(job);
    without.hasPicture = false;
    EXPECT_THAT(stagesIn({without, job}), testing::ElementsAre(name, "to-screen"));
  }
}

/// Another technique or another knob shows the same: nothing is done until the camera leaves.
TEST_F(PicturePlanTest, WhileAShortcutIsOnShowTheTechniqueIsNotAtWork) {
  for (const Camera& camera : {someCamera(), zoomed(someCamera())}) {
    const WarpJob job = shortcut(camera);
    WarpJob other = job;
    other.technique = &findWarp("splats");
    EXPECT_THAT(stagesIn({after(job), other}), testing::IsEmpty());
    other = job;
    other.settings.knobs.set(kPointSizeKnob, 5);
    EXPECT_THAT(stagesIn({after(job), other}), testing::IsEmpty());
    const PicturePlan plan({}, job);
    for (const PictureStage stage : {PictureStage::technique, PictureStage::build, PictureStage::draw})
      EXPECT_EQ(plan[stage].reason, "a shortcut takes the technique's place");
    WarpJob left = job;
    left.camera = job_.camera;
    EXPECT_THAT(stagesIn({after(job), left}), testing::ElementsAre("technique", "build", "draw", "to-screen"));
    left = job;
    left.takesShortcuts = false;
    EXPECT_THAT(stagesIn({after(job), left}), testing::ElementsAre("technique", "build", "draw", "to-screen"));
  }
}

/// The technique is made and built from a frame, and a shortcut was on show in between.
TEST_F(PicturePlanTest, WhatIsBuiltOutlivesAShortcut) {
  EaselState last = after(job_);
  last.way = PictureWay::ownPicture;
  last.camera = job_.camera;
  EXPECT_THAT(stagesIn({last, job_}), testing::ElementsAre("draw", "to-screen"));
  last = after(job_);
  last.hasPicture = false;  // it was built, and drew nothing
  EXPECT_THAT(stagesIn({last, job_}), testing::ElementsAre("draw", "to-screen"));
}

TEST_F(PicturePlanTest, ATechniqueIsMadeForItsVolume) {
  EaselState last = after(job_);
  WarpJob other = job_;
  other.technique = &findWarp("splats");
  EXPECT_THAT(stagesIn({last, other}), testing::ElementsAre("technique", "build", "draw", "to-screen"));
  EXPECT_EQ(PicturePlan(last, other)[PictureStage::technique].reason, "it was spheres");
  other = job_;
  other.marcher = anotherMarcher();
  EXPECT_THAT(stagesIn({last, other}), testing::ElementsAre("technique", "build", "draw", "to-screen"));
  EXPECT_EQ(PicturePlan(last, other)[PictureStage::technique].reason, "the volume is another one");
  EXPECT_EQ(PicturePlan({}, job_)[PictureStage::technique].reason, "there is none yet");
}

TEST_F(PicturePlanTest, AFrameIsBuiltOnce) {
  const EaselState last = after(job_);
  WarpJob next = job_;
  next.frame = frameOf(someCamera());
  EXPECT_THAT(stagesIn({last, next}), testing::ElementsAre("build", "draw", "to-screen"));
  EXPECT_EQ(PicturePlan(last, next)[PictureStage::build].reason, "the frame is new");
  for (int i = 1; i <= 10; ++i) {
    next = job_;
    next.camera = turned(job_.camera, static_cast<float>(i));
    EXPECT_THAT(stagesIn({last, next}), testing::ElementsAre("draw", "to-screen"));
    EXPECT_EQ(PicturePlan(last, next)[PictureStage::draw].reason, "the camera moved");
  }
  // It was made, and given nothing: as after a build that failed.
  EaselState made = last;
  made.isBuilt = false;
  EXPECT_TRUE(PicturePlan(made, job_).has(PictureStage::build));
  WarpJob none = job_;
  none.frame.reset();
  EaselState never = after(none);
  EXPECT_FALSE(PicturePlan(never, none).has(PictureStage::build));
  never.isBuilt = false;
  EXPECT_TRUE(PicturePlan(never, none).has(PictureStage::build));
}

TEST_F(PicturePlanTest, KnobsSayWhatTheyMakeStale) {
  WarpJob next = job_;
  next.settings.knobs.set(kArithmeticKnob, Arithmetic::textbook);
  EXPECT_THAT(stagesIn({after(job_), next}), testing::ElementsAre("build", "draw", "to-screen"));
  EXPECT_THAT(PicturePlan(after(job_), next)[PictureStage::build].reason, testing::HasSubstr("knob"));
  WarpJob points = job_;
  points.technique = &findWarp("points");
  WarpJob larger = points;
  larger.settings.knobs.set(kPointSizeKnob, 5);
  EXPECT_THAT(stagesIn({after(points), larger}), testing::ElementsAre("draw", "to-screen"));
  EXPECT_THAT(PicturePlan(after(points), larger)[PictureStage::draw].reason, testing::HasSubstr("knob"));
}

TEST_F(PicturePlanTest, WhatDrawsFromNoFrameIsNotBuilt) {
  WarpJob job = job_;
  job.technique = &findWarp("reference");
  job.frame.reset();
  EXPECT_THAT(stagesIn({{}, job}), testing::ElementsAre("technique", "draw", "to-screen"));
  EXPECT_THAT(stagesIn({after(job_), job}), testing::ElementsAre("technique", "draw", "to-screen")) << "another one drew what this camera sees";
  EXPECT_THAT(stagesIn({after(job), job}), testing::IsEmpty());
  WarpJob finer = job;
  finer.settings.reference.step = 0.25f;
  EXPECT_THAT(stagesIn({after(job), finer}), testing::ElementsAre("draw", "to-screen"));
}

TEST_F(PicturePlanTest, AnotherBackgroundDrawsNothingWhereTheColoursAreInTheHostsMemory) {
  WarpJob lighter = job_, marked = job_;
  lighter.background = glm::vec3(0.5f);
  marked.uncovered = 0xff0000ffu;
  for (const WarpJob& job : {lighter, marked}) {
    EXPECT_THAT(stagesIn({after(job_), job}), testing::ElementsAre("to-screen"));
    EaselState onDevice = after(job_);
    onDevice.isOnDevice = true;
    EXPECT_THAT(stagesIn({onDevice, job}), testing::ElementsAre("draw", "to-screen"));
    EXPECT_THAT(stagesIn({onDevice, job_}), testing::IsEmpty());
  }
  const WarpJob own = shortcut(someCamera());
  WarpJob ownLighter = own;
  ownLighter.background = glm::vec3(0.5f);
  EXPECT_THAT(stagesIn({after(own), ownLighter}), testing::ElementsAre("to-screen"));
}

TEST_F(PicturePlanTest, WhatIsJudgedIsWhatIsOnShow) {
  EXPECT_FALSE(PicturePlan(after(job_), job_).has(PictureStage::judge));
  WarpJob judged = job_;
  judged.reference = referenceAt(job_.camera);
  EXPECT_THAT(stagesIn({after(job_), judged}), testing::ElementsAre("judge"));
  EXPECT_THAT(PicturePlan(after(job_), judged)[PictureStage::judge].reason, testing::HasSubstr("this camera"));
  // An earlier camera's is judged once, by the technique.
  WarpJob moving = job_;
  moving.reference = referenceAt(turned(job_.camera, 2.0f));
  EXPECT_THAT(stagesIn({after(job_), moving}), testing::ElementsAre("judge"));
  EXPECT_THAT(stagesIn({after(moving), moving}), testing::IsEmpty());
  EXPECT_THAT(PicturePlan(after(moving), moving)[PictureStage::judge].reason, testing::HasSubstr("was judged"));
  // A shortcut's picture is judged as it is, and the technique is not built to say what an earlier camera saw.
  for (const Camera& camera : {someCamera(), zoomed(someCamera())}) {
    WarpJob own = shortcut(camera);
    own.reference = referenceAt(camera);
    EXPECT_THAT(stagesIn({after(shortcut(camera)), own}), testing::ElementsAre("judge"));
    own.reference = referenceAt(job_.camera);
    EXPECT_THAT(stagesIn({after(shortcut(camera)), own}), testing::IsEmpty());
    EXPECT_THAT(PicturePlan(after(shortcut(camera)), own)[PictureStage::judge].reason, testing::HasSubstr("not at work"));
  }
}

/// What the technique below was asked for, by all that were made of it.
struct Calls {
  std::atomic<uint64_t> made = 0, builds = 0, draws = 0;
};
Calls& calls() {
  static Calls all;
  return all;
}

/// Splats, counted.
class CountedWarp final : public Warp {
 public:
  explicit CountedWarp(const WarpResources& resources) : warp_(makeWarp(findWarp("splats"), resources)) { ++calls().made; }

  void setFrame(SampleFramePtr frame, const WarpSettings& settings, const std::stop_token& stop) override {
    ++calls().builds;
    warp_->setFrame(std::move(frame), settings, stop);
  }
  void draw(const Camera& camera, const WarpSettings& settings, WarpedImage& image, const std::stop_token& stop) override {
    ++calls().draws;
    warp_->draw(camera, settings, image, stop);
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
    .make = [](const WarpResources& resources) -> std::unique_ptr<Warp> { return std::make_unique<CountedWarp>(resources); },
};

/// The worker itself, on its thread.
class PictureCounts : public testing::Test {
 protected:
  PictureCounts() {
    calls().made = calls().builds = calls().draws = 0;
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
    return std::make_shared<const ReferenceImage>(ReferenceJob{marcher_, camera, stage_.scene().march.render, {}}, std::move(color));
  }

  Stage stage_{smallScene("block", 32)};
  const Camera home_ = stage_.camera(40, 56);
  const MarcherPtr marcher_ = makeMarcher(Backend::cpu, stage_.scene().volume, stage_.scene().transferFunction);
  WarpJob job_;
  std::counting_semaphore<> news_{0};
  const std::unique_ptr<WarpWorker> worker_ = makeWarpWorker(
      gl::Platform::automatic, {.marcher = {}, .context = {}, .backend = Backend::cpu, .onFallback = {}}, [this] { news_.release(); });
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
  EXPECT_EQ(paint(job_).counts, (WarpCounts{.made = 1, .builds = 1, .draws = 1, .shortcuts = 2}));
  job_.camera = elsewhere;
  EXPECT_EQ(paint(job_).counts, (WarpCounts{.made = 1, .builds = 1, .draws = 2, .shortcuts = 2})) << "what was built is still there";
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

TEST_F(PictureCounts, ATurnTakesNoTechnique) {
  job_.takesShortcuts = true;
  uint64_t shortcuts = 0;
  for (const Camera& camera : {turned(home_, 3.0f), zoomed(home_), resized(home_, 64, 48)}) {
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

TEST_F(PictureCounts, BeginAnewWithAnotherVolume) {
  paint(job_);
  WarpJob other = job_;
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
