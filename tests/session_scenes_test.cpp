// The scenes of a session: opened, replaced, refused, given up.
// Mirrors app/session/scene_opening.h and what app/session/session.h does with it.
#include <latch>

#include "app/session/session.h"
#include "tests/session_fixture.h"

namespace warpscope {
namespace {

TEST_F(SessionTest, AnotherSceneReplacesEverythingButWhatWasTurnedOfWhatIsSent) {
  ASSERT_TRUE(open("block"));
  const uint64_t before = session_.frames().newest()->requestId;
  LiveSettings knobs = session_.knobs();
  knobs.march.sample.heuristic = Heuristic::exit;
  knobs.march.sample.threshold = 0.4f;
  knobs.march.render.step = 0.7f;
  session_.setKnobs(knobs);
  session_.load(builtin("shells"));
  EXPECT_EQ(session_.loading(), "shells");
  EXPECT_EQ(session_.scene()->name, "block");  // until the other one is there
  ASSERT_TRUE(pumpUntil([&] { return session_.scene()->name == "shells"; }));
  ASSERT_TRUE(settle());
  EXPECT_GT(session_.frames().newest()->requestId, before);
  MarchSettings expected = session_.scene()->march;
  expected.sample.heuristic = Heuristic::exit;
  expected.sample.threshold = 0.4f;
  EXPECT_EQ(session_.knobs().march, expected) << "how the picture looks is the scene's";

  // What a scene says itself is not overruled; what was taken back is not turned any more.
  knobs = session_.knobs();
  knobs.march.sample.threshold = session_.scene()->march.sample.threshold;
  session_.setKnobs(knobs);
  session_.load(job("with peaks", [](const std::stop_token& stop) {
    SceneOverrides overrides;
    overrides.proceduralDims = {16, 16, 16};
    Scene scene = openScene("block", overrides, stop);
    scene.march.sample.heuristic = Heuristic::peak;
    return scene;
  }));
  ASSERT_TRUE(pumpUntil([&] { return session_.sceneCount() == 3; }));
  EXPECT_EQ(session_.knobs().march, session_.scene()->march);
}

TEST_F(SessionTest, OfTwoScenesTheOneAskedForLastIsShown) {
  session_.load(builtin("block"));
  session_.load(builtin("shells"));
  session_.load(builtin("marschner-lobb"));
  ASSERT_TRUE(settle());
  EXPECT_EQ(session_.scene()->name, "marschner-lobb");
}

/// Loads that go on until they are told to stop.
TEST_F(SessionTest, ALoadEndsWhenItIsCancelledOrReplaced) {
  std::latch begun(1), ended(2);
  const auto endless = [&](const std::stop_token& stop) -> Scene {
    while (!stop.stop_requested()) std::this_thread::sleep_for(milliseconds(1));
    ended.count_down();
    throw OperationCancelled();
  };
  ASSERT_TRUE(open("block"));
  session_.load(job("one", [&](const std::stop_token& stop) {
                   begun.count_down();
                   return endless(stop);
                 }));
  begun.wait();
  EXPECT_EQ(session_.loading(), "one");
  session_.cancelLoad();
  EXPECT_EQ(session_.loading(), "");
  std::latch again(1);
  session_.load(job("two", [&](const std::stop_token& stop) {
                   again.count_down();
                   return endless(stop);
                 }));
  again.wait();
  session_.load(builtin("shells"));
  ended.wait();
  ASSERT_TRUE(pumpUntil([&] { return session_.scene()->name == "shells"; }));
  EXPECT_EQ(session_.loading(), "");
  EXPECT_EQ(session_.error(), "");
}

TEST_F(SessionTest, ASceneThatCannotBeOpenedIsASentence) {
  ASSERT_TRUE(open("block"));
  session_.load(job("nowhere.nrrd", [](const std::stop_token&) -> Scene { throw InputError("nowhere.nrrd: there is no such file"); }));
  ASSERT_TRUE(pumpUntil([&] { return session_.loading().empty(); }));
  EXPECT_EQ(session_.error(), "nowhere.nrrd: there is no such file");
  EXPECT_EQ(session_.scene()->name, "block");
  session_.dismissErrors();
  EXPECT_EQ(session_.error(), "");
}

TEST_F(SessionTest, NothingIsKeptOfASceneThatWasReplaced) {
  session_.setPanels({{.technique = &findWarp("hold")}, {.technique = &findWarp("spheres")}, {.technique = &findWarp("reference")}});
  ASSERT_TRUE(open("shells"));
  session_.setShowsPlan(true);
  ASSERT_TRUE(pumpUntil([&] { return session_.plan().areCurrent(); }));
  session_.lookAt(LookedAt{session_.panel(0).id, {0.5, 0.5}});
  ASSERT_TRUE(pumpUntil([&] { return session_.ray().isCurrent(); }));
  session_.measureNow();
  ASSERT_TRUE(session_.fair().isMeasuring());
  ASSERT_TRUE(pumpUntil([&] { return !session_.fair().isMeasuring(); }));
  session_.lookAt({});
  for (const size_t panel : {1, 2}) session_.setHidden(panel, true);  // nothing else comes for their threads
  const std::weak_ptr<const Volume> volume = session_.scene()->volume;
  const std::weak_ptr<const SampleFrame> frame = session_.frames().newest();
  ASSERT_FALSE(volume.expired());
  ASSERT_TRUE(open("block"));
  EXPECT_TRUE(pumpUntil([&] { return volume.expired(); }));
  EXPECT_TRUE(pumpUntil([&] { return frame.expired(); }));
}

/// An opened scene that nobody took yet: its server ends in the background.
TEST_F(SessionTest, WhatWasOpenedAndNotTakenEndsElsewhere) {
  std::weak_ptr<const Volume> volume;
  std::atomic<bool> isOpen = false;
  LoadJob late = builtin("shells");
  late.open = [&, inner = late.open](const std::function<void()>& onNews, const std::stop_token& stop) {
    ConnectedScene opened = inner(onNews, stop);
    volume = opened.scene.volume;
    isOpen = true;
    return opened;
  };
  ASSERT_TRUE(open("block"));
  session_.load(late);
  while (!isOpen) std::this_thread::sleep_for(milliseconds(1));
  std::this_thread::sleep_for(milliseconds(50));
  session_.cancelLoad();
  EXPECT_TRUE(session_.close(kPatience));
  EXPECT_TRUE(volume.expired()) << "who closes waits for it, too";
}

TEST_F(SessionTest, DoesNotWaitForALoadThatCannotBeInterrupted) {
  std::latch loading(1), gate(1);
  Session session(settings(), [] {});
  session.load(job("slow", [&](const std::stop_token&) -> Scene {
                 loading.count_down();
                 gate.wait();
                 throw InputError("too late");
               }));
  loading.wait();
  EXPECT_FALSE(session.close(milliseconds(10)));
  gate.count_down();
  EXPECT_TRUE(session.close(kPatience));
}

}  // namespace
}  // namespace warpscope
