// Cameras that move by themselves: the same view at the same time, within what views may be; paths between what was recorded.
// Mirrors app/scene/camera_motion.h and app/session/live_motion.h.
#include "app/scene/camera_motion.h"

#include <gmock/gmock.h>

#include "app/session/live_motion.h"

namespace warpscope {
namespace {

View homeView() { return {.angleDeg = 170.0, .elevationDeg = 80.0, .distance = 1.2, .pan = {0.1, 0.0}}; }

CameraPath pathOf(std::initializer_list<std::pair<double, double>> angles) {
  CameraPath path;
  for (const auto& [seconds, angle] : angles) path.add(seconds, {.angleDeg = angle});
  return path;
}

TEST(CameraMotions, BeginWhereTheCameraIsAndStayWithinWhatViewsMayBe) {
  const CameraPath path = pathOf({{0.0, 170.0}, {1.0, -170.0}});
  for (const CameraMotionDescriptor& motion : cameraMotions()) {
    SCOPED_TRACE(motion.name);
    EXPECT_EQ(&describe(motion.value), &motion);
    EXPECT_FALSE(motion.help.empty() || motion.help.ends_with('.'));
    if (motion.value != CameraMotion::recorded) {
      EXPECT_EQ(movedView(motion.value, homeView(), 0.0, 1.0, path), homeView());
    }
    bool hasMoved = false;
    for (double seconds = 0.0; seconds < 60.0; seconds += 0.01) {
      const View view = movedView(motion.value, homeView(), seconds, 1.0, path), next = movedView(motion.value, homeView(), seconds + 0.01, 1.0, path);
      ASSERT_LE(std::abs(view.angleDeg), 180.0);
      ASSERT_LE(std::abs(view.elevationDeg), 90.0);
      ASSERT_GT(view.distance, 0.3);
      ASSERT_LT(view.distance, 4.0);
      ASSERT_LT(std::abs(std::remainder(next.angleDeg - view.angleDeg, 360.0)), 1.0) << "no jumps";
      hasMoved |= view != homeView();
    }
    EXPECT_EQ(hasMoved, motion.value != CameraMotion::none);
    EXPECT_EQ(movedView(motion.value, homeView(), 2.0, 1.0, path), movedView(motion.value, homeView(), 1.0, 2.0, path)) << "twice as fast";
  }
}

TEST(CameraMotions, LeaveNoViewThatFilesRefuse) {
  for (const double distance : {kViewDistanceRange.lowest, kViewDistanceRange.highest})
    for (const CameraMotionDescriptor& motion : cameraMotions())
      for (double seconds = 0.0; seconds < 30.0; seconds += 0.1) {
        const View view = movedView(motion.value, {.distance = distance, .pan = {kMostViewPan, -kMostViewPan}}, seconds, 1.0, pathOf({{0.0, 0.0}}));
        ASSERT_GE(view.distance, kViewDistanceRange.lowest) << motion.name;
        ASSERT_LE(view.distance, kViewDistanceRange.highest) << motion.name;
        ASSERT_LE(std::abs(view.pan.x), kMostViewPan) << motion.name;
        ASSERT_LE(std::abs(view.pan.y), kMostViewPan) << motion.name;
      }
}

TEST(CameraPaths, GoBetweenWhatWasRecordedTheShortWayAround) {
  CameraPath path = pathOf({{0.0, 170.0}, {2.0, -170.0}});
  EXPECT_NEAR(std::abs(path.at(1.0).angleDeg), 180.0, 1e-9);
  EXPECT_DOUBLE_EQ(path.at(-1.0).angleDeg, 170.0);
  EXPECT_DOUBLE_EQ(path.at(9.0).angleDeg, -170.0);
  path.add(2.0, {.angleDeg = 5.0});
  EXPECT_EQ(path.views().size(), 2u) << "the same time again replaces";
  EXPECT_DOUBLE_EQ(path.at(2.0).angleDeg, 5.0);
  for (size_t i = 0; i < 2 * CameraPath::kMost; ++i) path.add(3.0 + static_cast<double>(i), {});
  EXPECT_EQ(path.views().size(), CameraPath::kMost);
  EXPECT_EQ(movedView(CameraMotion::recorded, homeView(), 1.0, 1.0, CameraPath{}), homeView()) << "nothing was recorded";
}

TEST(LiveMotions, EndWhenSomebodyElseMovesTheCamera) {
  LiveMotion motion;
  Clock::TimePoint now{};
  View view = homeView();
  const auto pass = [&](int ms) {
    now += std::chrono::milliseconds(ms);
    view = motion.update(view, now);
  };
  motion.start(CameraMotion::orbit, 1.0);
  pass(0);
  EXPECT_EQ(view, homeView());
  pass(1000);
  EXPECT_NEAR(std::remainder(view.angleDeg - homeView().angleDeg, 360.0), 30.0, 1e-6);
  view.elevationDeg -= 1.0;
  const View moved = view;
  pass(1000);
  EXPECT_EQ(view, moved);
  EXPECT_EQ(motion.motion(), CameraMotion::none);
}

TEST(LiveMotions, RepeatWhatWasRecorded) {
  LiveMotion motion;
  Clock::TimePoint now{};
  View view = homeView();
  motion.setRecording(true);
  EXPECT_TRUE(motion.isRecording());
  for (int i = 0; i <= 10; ++i) {
    view.distance = 1.0 + 0.1 * i;
    view = motion.update(view, now += std::chrono::milliseconds(100));
  }
  motion.start(CameraMotion::recorded, 1.0);
  EXPECT_FALSE(motion.isRecording()) << "it would record itself";
  ASSERT_EQ(motion.path().views().size(), 11u);
  view = motion.update(view, now);
  EXPECT_NEAR(view.distance, 1.0, 1e-9) << "from its beginning";
  view = motion.update(view, now += std::chrono::milliseconds(550));
  EXPECT_NEAR(view.distance, 1.55, 1e-9);
  view = motion.update(view, now += std::chrono::milliseconds(950));
  EXPECT_NEAR(view.distance, 1.5, 1e-9) << "on the way back";
}

}  // namespace
}  // namespace warpscope
