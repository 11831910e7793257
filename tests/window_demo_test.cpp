// Demonstrations in the window: how one begins, and how it is taken back.
#include <gmock/gmock.h>

#include "app/session/demos.h"
#include "tests/window_script.h"

namespace warpscope::ui {
namespace {

using WindowDemoTest = WindowScriptTest;

TEST_F(WindowDemoTest, BeginsWhenThereIsAFrameThatHasWhatItDraws) {
  ASSERT_TRUE(openAndRest("block"));
  const auto isDrawable = [&] {
    const SampleFramePtr& frame = session_.frames().newest();
    return frame != nullptr && lackOf(findWarp("segments"), frame->settings).empty();
  };
  ASSERT_FALSE(isDrawable()) << "nothing on show draws segments";
  window_.view().start(demos().front(), session_);
  ASSERT_EQ(session_.panel(1).technique, &findWarp("segments"));
  EXPECT_EQ(session_.motion().motion(), CameraMotion::none);
  EXPECT_EQ(session_.knobs().transport.link, net::DuplexLinkSettings{});
  ASSERT_TRUE(waitUntil([&] {
    if (session_.motion().motion() == CameraMotion::none) EXPECT_EQ(session_.knobs().transport.link, net::DuplexLinkSettings{});
    return session_.motion().motion() != CameraMotion::none;
  }));
  EXPECT_TRUE(isDrawable());
  EXPECT_EQ(session_.motion().motion(), CameraMotion::orbit);
  EXPECT_FALSE(session_.knobs().transport.link == net::DuplexLinkSettings{});
}

TEST_F(WindowDemoTest, IsTakenBackAsAWhole) {
  ASSERT_TRUE(openAndRest("block"));
  const View view = session_.view();
  const auto begin = [&] {
    window_.view().start(demos().front(), session_);
    const bool hasBegun = waitUntil([&] { return session_.motion().motion() != CameraMotion::none; });
    window_.frames(2);
    return hasBegun;
  };
  const auto expectAsBefore = [&] {
    EXPECT_EQ(session_.motion().motion(), CameraMotion::none);
    EXPECT_EQ(session_.knobs().transport.link, net::DuplexLinkSettings{});
    EXPECT_EQ(session_.panel(1).technique, &findWarp("spheres"));
    EXPECT_EQ(session_.view(), view);
  };
  ASSERT_TRUE(begin());
  press(Action::undo);
  EXPECT_EQ(window_.view().note(), "taken back: the demo");
  expectAsBefore();
  window_.frames(2);
  press(Action::undo);  // there is nothing before it
  expectAsBefore();
  // What a hand did meanwhile goes first, and by itself.
  ASSERT_TRUE(begin());
  LiveSettings knobs = session_.knobs();
  knobs.march.sample.heuristic = Heuristic::median;
  session_.setKnobs(knobs);
  window_.frames(2);
  press(Action::undo);
  EXPECT_NE(session_.knobs().march.sample.heuristic, Heuristic::median);
  EXPECT_EQ(session_.motion().motion(), CameraMotion::orbit);
  window_.frames(2);
  press(Action::undo);
  EXPECT_EQ(window_.view().note(), "taken back: the demo");
  expectAsBefore();
  // Before its frame has come.
  window_.view().start(demos().front(), session_);
  press(Action::undo);
  expectAsBefore();
}

TEST_F(WindowDemoTest, WhatAHandDoesWhileItWaitsIsNotTakenAway) {
  ASSERT_TRUE(openAndRest("block"));
  window_.view().start(demos().front(), session_);
  window_.frame();
  View view = session_.view();
  view.angleDeg += 40.0;
  session_.setView(view);
  const auto from = std::chrono::steady_clock::now();
  waitUntil([&] { return std::chrono::steady_clock::now() - from > std::chrono::seconds(4); });
  EXPECT_EQ(session_.view(), view);
  EXPECT_EQ(session_.motion().motion(), CameraMotion::none);
  EXPECT_EQ(session_.knobs().transport.link, net::DuplexLinkSettings{});
}

TEST_F(WindowDemoTest, InAnotherSceneThereIsNothingOfItToTakeBack) {
  ASSERT_TRUE(openAndRest("block"));
  window_.view().start(demos().front(), session_);
  ASSERT_TRUE(waitUntil([&] { return session_.motion().motion() != CameraMotion::none; }));
  session_.load(jobOf({"shells", {}}));
  ASSERT_TRUE(waitUntil([&] { return session_.loading().empty() && session_.scene()->name == "shells"; }));
  session_.setMotion(CameraMotion::none);
  View view = session_.view();
  view.angleDeg += 40.0;
  session_.setView(view);
  window_.frames(2);
  press(Action::undo);
  EXPECT_EQ(session_.view(), view);
  EXPECT_EQ(session_.panel(1).technique, &findWarp("segments"));
}

using WindowCornerTest = WindowScriptTest;

TEST_F(WindowCornerTest, DeleteRemovesTheChosenOneWhileThePointerIsThere) {
  ASSERT_TRUE(openAndRest("block"));
  const TransferFunction before = session_.scene()->transferFunction;
  window_.click(kChart);
  ASSERT_NE(session_.scene()->transferFunction, before);
  const TransferFunction withCorner = session_.scene()->transferFunction;
  window_.moveTo(kChart + glm::vec2(0.0f, 300.0f));
  tap(ImGuiKey_Delete);
  EXPECT_EQ(session_.scene()->transferFunction, withCorner) << "the pointer is elsewhere";
  window_.moveTo(kChart);
  tap(ImGuiKey_Delete);
  EXPECT_NE(session_.scene()->transferFunction, withCorner);
  EXPECT_THAT(window_.view().note(), testing::StartsWith("the corner is gone"));
  EXPECT_EQ(session_.panelCount(), 2u);
  // The last one, behind which there is none.
  const TransferFunction without = session_.scene()->transferFunction;
  window_.click({1251.0f, 161.0f}, 1);
  EXPECT_NE(session_.scene()->transferFunction, without);
}

}  // namespace
}  // namespace warpscope::ui
