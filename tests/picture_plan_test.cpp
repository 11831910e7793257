// Each stage of a panel's picture is in where it is needed and out where it is not.
// Mirrors app/session/picture_plan.h; that the worker does what the plan says is in picture_counts_test.cpp.
#include "app/session/picture_plan.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string_view>
#include <utility>
#include <vector>

#include "app/frames/backend.h"
#include "render/warp/arithmetic_knob.h"
#include "render/warp/points_warp.h"
#include "tests/headless.h"
#include "tests/marcher_cases.h"
#include "tests/moved_cameras.h"

namespace warpscope {
namespace {

Camera someCamera() { return lookingFrom({3.0f, 4.0f, 60.0f}, {}, 40, 30); }

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
    state.scene = job.scene;
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
  state.marks = job.marks;
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
    return std::make_shared<const ReferenceImage>(ReferenceJob{marcher_, camera, {}, {}},
                                                  Image<glm::vec4>(camera.width, camera.height));
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
      for (const PictureStageDescriptor& stage : kPictureStages)
        EXPECT_FALSE(PicturePlan(last, job)[stage.stage].reason.empty()) << stage.name;
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
  EXPECT_THAT(stagesIn({after(job_), job}), testing::ElementsAre("own-picture", "to-screen"))
      << "the technique drew what is on show";
  EXPECT_THAT(stagesIn({after(shortcut(zoomed(someCamera()))), job}), testing::ElementsAre("own-picture", "to-screen"));
  for (const Camera& other : {ofSize(someCamera(), 41, 30), zoomed(someCamera()), turned(someCamera(), 1.0f),
                              withEye(someCamera(), {3.0f, 4.0f, 61.0f})}) {
    EXPECT_FALSE(PicturePlan({}, shortcut(other)).has(PictureStage::ownPicture));
    EXPECT_EQ(PicturePlan({}, shortcut(other))[PictureStage::ownPicture].reason, "the camera is not the frame's");
  }
}

TEST_F(PicturePlanTest, TheFramesEyeTakesNoDepth) {
  for (const Camera& camera : {ofSize(someCamera(), 41, 30), zoomed(someCamera()), turned(someCamera(), 1.0f)}) {
    const WarpJob job = shortcut(camera);
    const PicturePlan plan({}, job);
    EXPECT_EQ(plan.way(), PictureWay::rotation);
    EXPECT_THAT(stagesIn(plan), testing::ElementsAre("rotation", "to-screen"));
    EXPECT_THAT(stagesIn({after(job), job}), testing::IsEmpty()) << "it is on show";
    EXPECT_THAT(stagesIn({after(job_), job}), testing::ElementsAre("rotation", "to-screen"))
        << "the technique drew what is on show";
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
  EXPECT_THAT(PicturePlan({}, shortcut(someCamera()))[PictureStage::rotation].reason,
              testing::HasSubstr("nothing is turned"));
}

TEST_F(PicturePlanTest, ShortcutsAreForFramesAndForWhoWantsThem) {
  for (const Camera& camera : {someCamera(), turned(someCamera(), 1.0f)}) {
    WarpJob off = shortcut(camera);
    off.takesShortcuts = false;
    WarpJob alone = shortcut(camera);
    alone.technique = &findWarp("reference");
    WarpJob without = shortcut(camera);
    without.frame.reset();
    const std::pair<WarpJob, const char*> cases[] = {
        {off, "switched off"}, {alone, "reference draws from no frame"}, {without, "there is no frame"}};
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
  for (const auto& [camera, name] :
       {std::pair(someCamera(), "own-picture"), std::pair(turned(someCamera(), 1.0f), "rotation")}) {
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
  other.scene = job_.scene + 1;
  EXPECT_THAT(stagesIn({last, other}), testing::ElementsAre("technique", "build", "draw", "to-screen"));
  EXPECT_EQ(PicturePlan(last, other)[PictureStage::technique].reason, "the scene is another one");
  other = job_;
  other.marcher = anotherMarcher();  // of another transfer function: what draws frames goes on
  EXPECT_THAT(stagesIn({last, other}), testing::ElementsAre());
  WarpJob marched = job_;
  marched.technique = &findWarp("reference");
  other.technique = marched.technique;
  EXPECT_EQ(PicturePlan(after(marched), other)[PictureStage::technique].reason, "it marches, and by another transfer function");
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
  EXPECT_THAT(stagesIn({after(job_), job}), testing::ElementsAre("technique", "draw", "to-screen"))
      << "another one drew what this camera sees";
  EXPECT_THAT(stagesIn({after(job), job}), testing::IsEmpty());
  WarpJob finer = job;
  finer.settings.reference.step = 0.25f;
  EXPECT_THAT(stagesIn({after(job), finer}), testing::ElementsAre("draw", "to-screen"));
}

TEST_F(PicturePlanTest, AnotherBackgroundDrawsNothingWhereTheColoursAreInTheHostsMemory) {
  WarpJob lighter = job_, marked = job_;
  lighter.background = glm::vec3(0.5f);
  marked.marks.uncovered = 0xff0000ffu;
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
    EXPECT_THAT(PicturePlan(after(shortcut(camera)), own)[PictureStage::judge].reason,
                testing::HasSubstr("not at work"));
  }
}

}  // namespace
}  // namespace warpscope
