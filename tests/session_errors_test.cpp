// How wrong a session's pictures are, live: figures, heat maps, histories, the front; and that finding out holds nothing up.
// Mirrors app/session/live_ground_truth.h, the errors of app/session/live_panel.h and app/session/picture_timing.h. Threads are real, volumes and images tiny.
#include <cmath>

#include "app/picture/content.h"
#include "app/picture/heat_map.h"
#include "render/warp/points_warp.h"
#include "tests/session_fixture.h"

namespace warpscope {
namespace {

using SessionErrorsTest = SessionTest;

/// What the panel draws, drawn again, and its ground truth.
struct Redrawn {
  WarpedImage image;
  Image<glm::vec4> reference;
};

Redrawn redrawn(const Session& session, size_t panel) {
  Redrawn result;
  const Scene& scene = *session.scene();
  const glm::uvec2 size = session.pictureSize();
  const Camera camera = makeCamera(scene, session.view(), size.x, size.y);
  WarpResources resources;
  resources.marcher = makeMarcher(Backend::cpu, scene.volume, scene.transferFunction);
  WarpSettings settings = session.knobs().warp;
  settings.reference = session.knobs().march.render;
  const std::unique_ptr<Warp> warp = makeWarp(*session.panel(panel).technique, resources);
  warp->setFrame(session.frames().newest(), settings);
  warp->draw(camera, settings, result.image);
  resources.marcher->render(camera, session.knobs().march.render, result.reference, {});
  return result;
}

void freeze(Session& session) {
  LiveSettings knobs = session.knobs();
  knobs.isFrozen = true;
  session.setKnobs(knobs);
}

TEST_F(SessionErrorsTest, AreThoseOfTheJudgeOnTheSamePictures) {
  ASSERT_TRUE(open("shells"));
  freeze(session_);
  turn(session_, 25.0);
  ASSERT_TRUE(pumpUntil([&] { return session_.panel(0).errorsAreCurrent && session_.panel(1).errorsAreCurrent; }));
  for (size_t i = 0; i < session_.panelCount(); ++i) {
    const Redrawn again = redrawn(session_, i);
    Image<float> map;
    const PictureErrors expected = PictureJudge(again.reference, session_.scene()->background).errorsOf(again.image, nullptr, &map);
    const PictureErrors& errors = *session_.panel(i).errors;
    EXPECT_GT(errors.flip, 0.01);  // a frame from 25 degrees away cannot be right
    EXPECT_DOUBLE_EQ(errors.flip, expected.flip);
    EXPECT_DOUBLE_EQ(errors.psnrDb, expected.psnrDb);
    EXPECT_DOUBLE_EQ(errors.ssim, expected.ssim);
    EXPECT_DOUBLE_EQ(errors.holeFraction, expected.holeFraction);
    session_.setContent(i, PictureContent::flip);
    ASSERT_TRUE(pumpUntil([&] { return session_.panel(i).isContentFound(); }));
    EXPECT_EQ(*session_.panel(i).shownContent.picture.host, heatMap(map, kHeatGain));
    EXPECT_DOUBLE_EQ(session_.panel(i).errors->flip, expected.flip);  // found again, and the same
  }
  EXPECT_NE(session_.panel(0).errors->flip, session_.panel(1).errors->flip);  // hold and spheres
}

TEST_F(SessionErrorsTest, TheReferenceHasNone) {
  session_.setTechnique(0, findWarp("reference"));
  ASSERT_TRUE(open("block"));
  EXPECT_EQ(session_.panel(0).errors->flip, 0.0);
  EXPECT_TRUE(std::isinf(session_.panel(0).errors->psnrDb));
  EXPECT_EQ(session_.panel(0).errors->holeFraction, 0.0);
  EXPECT_EQ(session_.panel(0).configuration, std::nullopt);
}

/// Judges that do not come to an end hold up no picture: panels draw on while theirs are stuck in the first.
TEST_F(SessionErrorsTest, AMovingCameraGetsItsPicturesWhileJudgesAreAtWork) {
  std::atomic<bool> mayEnd = false;
  std::atomic<int> begun = 0;
  SessionSettings stuck = settings();
  stuck.makeJudge = [&]() -> JudgeFunction {
    return [&](const std::shared_ptr<const ReferenceImage>& reference, const WarpedImage& image, Image<float>& map) {
      ++begun;
      while (!mayEnd) std::this_thread::sleep_for(milliseconds(1));
      return reference->judge().errorsOf(image, nullptr, &map);
    };
  };
  Session session(stuck, [] {});
  session.setPanelSize(kPanelPx);
  session.load(builtin("block"));
  const bool bothBegan = pumpUntil(session, [&] { return begun == 2; });
  int shown = 0;
  for (int i = 0; bothBegan && i < 5; ++i) {
    const std::array<ShownPicture, 2> before{session.panel(0).picture, session.panel(1).picture};
    turn(session, 5.0);
    shown += pumpUntil(session, [&] { return session.panel(0).picture != before[0] && session.panel(1).picture != before[1]; });
  }
  EXPECT_EQ(begun, 2);
  EXPECT_FALSE(session.panel(0).errors || session.panel(1).errors);
  mayEnd = true;
  EXPECT_TRUE(bothBegan);
  EXPECT_EQ(shown, 5);
  EXPECT_TRUE(settle(session));
  EXPECT_TRUE(session.close(kPatience));
}

TEST_F(SessionErrorsTest, AContentIsOnShowOnlyWhileItIsTrue) {
  ASSERT_TRUE(open("block"));
  EXPECT_FALSE(session_.panel(1).hasContentOnShow());
  session_.setContent(1, PictureContent::flip);
  ASSERT_TRUE(settle());
  EXPECT_TRUE(session_.panel(1).hasContentOnShow());
  EXPECT_FALSE(session_.panel(0).hasContentOnShow());
  EXPECT_EQ(session_.panel(1).shownContent.picture.width(), session_.panel(1).picture.width());
  EXPECT_EQ(session_.panel(1).shownContent.picture.height(), session_.panel(1).picture.height());

  const ShownPicture atHome = session_.panel(1).shownContent.picture;
  turn(session_, 20.0);
  session_.update(clock_.now());
  EXPECT_FALSE(session_.panel(1).hasContentOnShow());  // moving
  ASSERT_TRUE(settle());
  EXPECT_TRUE(session_.panel(1).hasContentOnShow());
  EXPECT_NE(session_.panel(1).shownContent.picture, atHome);

  session_.setTechnique(1, findWarp("hold"));
  EXPECT_FALSE(session_.panel(1).hasContentOnShow());  // that of another technique
  ASSERT_TRUE(settle());
  EXPECT_TRUE(session_.panel(1).hasContentOnShow());
  session_.setContent(1, PictureContent::picture);
  EXPECT_FALSE(session_.panel(1).hasContentOnShow());

  session_.setContent(1, PictureContent::flip);
  session_.load(builtin("shells"));
  ASSERT_TRUE(pumpUntil([&] { return session_.scene()->name == "shells"; }));
  EXPECT_FALSE(session_.panel(1).hasContentOnShow());
  ASSERT_TRUE(settle());
  EXPECT_TRUE(session_.panel(1).hasContentOnShow());  // the wish stays
}

TEST_F(SessionErrorsTest, EveryContentIsShownOrSaysWhyNot) {
  ASSERT_TRUE(open("block"));  // hold and spheres
  turn(session_, 10.0);
  ASSERT_TRUE(settle());
  const auto history = session_.panel(1).history.steps(clock_.now()).size();
  std::vector<Image<Rgba8>> pictures;
  for (const ContentDescriptor& content : pictureContents()) {
    if (content.value == PictureContent::picture) continue;
    for (size_t i = 0; i < session_.panelCount(); ++i) session_.setContent(i, content.value);
    ASSERT_TRUE(settle()) << content.name;
    if (content.value == PictureContent::segments) {
      EXPECT_THAT(session_.panel(1).shownContent.refusal, testing::HasSubstr("draws no segments"));
      continue;
    }
    ASSERT_TRUE(session_.panel(1).hasContentOnShow()) << content.name;
    const PanelContent& shown = session_.panel(1).shownContent;
    EXPECT_EQ(shown.hasRamp, !content.unit.empty()) << content.name;
    for (const Image<Rgba8>& other : pictures) EXPECT_NE(*shown.picture.host, other) << content.name;
    pictures.push_back(*shown.picture.host);
    // What is held still shows pixels, not samples at places.
    EXPECT_EQ(session_.panel(0).hasContentOnShow(), session_.panel(0).shownContent.refusal.empty()) << content.name;
  }
  EXPECT_EQ(session_.panel(1).history.steps(clock_.now()).size(), history);  // looking at something else is no new measurement
  session_.setContent(1, PictureContent::difference, 0.01f);
  ASSERT_TRUE(settle());
  EXPECT_EQ(session_.panel(1).shownContent.high, 0.01f);
  EXPECT_NE(*session_.panel(1).shownContent.picture.host, pictures.front());  // in another range
}

TEST_F(SessionErrorsTest, WhileTheCameraMovesTheyAreThoseOfSomePixels) {
  ASSERT_TRUE(open("block"));
  const double atRest = session_.panel(1).errors->flip;
  EXPECT_FALSE(session_.panel(1).movingErrors);
  session_.setMotion(CameraMotion::orbit, 0.05);
  for (const size_t i : {size_t{0}, size_t{1}}) {
    ASSERT_TRUE(pumpUntil([&] { return session_.panel(i).movingErrors.has_value(); })) << i;
    EXPECT_FALSE(session_.panel(i).errorsAreCurrent);
    EXPECT_TRUE(session_.panel(i).history.steps(clock_.now()).back().isSparse);
  }
  EXPECT_NEAR(session_.panel(1).movingErrors->flip, atRest, 0.03);
  session_.setMotion(CameraMotion::none);
  ASSERT_TRUE(settle());
  EXPECT_FALSE(session_.panel(1).movingErrors) << "there is better";
  EXPECT_FALSE(session_.panel(1).history.steps(clock_.now()).back().isSparse);
  faults_->render = true;
  session_.setMotion(CameraMotion::orbit, 0.05);
  for (int i = 0; i < 100; ++i) {
    session_.update(clock_.now());
    std::this_thread::sleep_for(milliseconds(10));
  }
  EXPECT_FALSE(session_.panel(1).movingErrors) << "no longer than they hold, and none where they cannot be had";
}

TEST_F(SessionErrorsTest, PicturesOfSegmentsShowHowManyAndWhere) {
  session_.setTechnique(1, findWarp("segments"));
  ASSERT_TRUE(open("block"));
  for (const PictureContent content : {PictureContent::segments, PictureContent::depth}) {
    session_.setContent(1, content);
    ASSERT_TRUE(settle());
    ASSERT_TRUE(session_.panel(1).hasContentOnShow()) << session_.panel(1).shownContent.refusal;
    EXPECT_GE(session_.panel(1).shownContent.high, 1.0f);
  }
  ASSERT_TRUE(session_.panel(1).currentPixels() != nullptr && session_.panel(1).currentPixels()->segments);
  session_.setContent(1, PictureContent::radius);
  ASSERT_TRUE(settle());
  EXPECT_NE(session_.panel(1).shownContent.refusal, "");
}

TEST_F(SessionErrorsTest, WhatTheGroundTruthHasNoSamplesForIsRefused) {
  session_.setTechnique(1, findWarp("reference"));
  ASSERT_TRUE(open("block"));
  session_.setContent(1, PictureContent::depth);
  ASSERT_TRUE(settle());
  EXPECT_FALSE(session_.panel(1).hasContentOnShow());
  EXPECT_NE(session_.panel(1).shownContent.refusal, "");
}

TEST_F(SessionErrorsTest, TheHistoryHasAGapWhileTheCameraMoves) {
  ASSERT_TRUE(open("block"));
  const Clock::TimePoint rested = clock_.now();
  session_.update(rested);
  std::vector<ErrorHistory::Step> steps = session_.panel(1).history.steps(rested);
  ASSERT_FALSE(steps.empty());
  EXPECT_EQ(steps.back().endS, 0.0);
  EXPECT_EQ(steps.back().value, session_.panel(1).errors->flip);

  turn(session_, 1.0);
  session_.update(rested + milliseconds(10));
  steps = session_.panel(1).history.steps(rested + seconds(2));
  ASSERT_FALSE(steps.empty());
  EXPECT_NEAR(steps.back().endS, 1.99, 1e-9);
}

/// A marcher that says it is on a device: its ground truth follows the camera.
TEST_F(SessionErrorsTest, WhereADeviceMarchesErrorsComeWhileTheCameraMoves) {
  faults_->isCuda = true;
  ASSERT_TRUE(open("block"));
  EXPECT_TRUE(session_.groundTruth().followsCamera());
  const size_t before = session_.panel(1).history.steps(clock_.now()).size();
  // Never at rest: every update sees another camera.
  ASSERT_TRUE(pumpUntil([&] {
    turn(session_, 0.05);
    return session_.panel(1).history.steps(clock_.now()).size() >= before + 3;
  }));
  EXPECT_TRUE(session_.panel(1).errorsAreCurrent);
  ASSERT_TRUE(settle());
  EXPECT_EQ(session_.error(), "");
}

/// What a shortcut was wrong by says nothing of what the technique draws a moment later.
TEST_F(SessionErrorsTest, ErrorsOfAShortcutAreNotThoseOfTheTechnique) {
  faults_->isCuda = true;
  LiveSettings knobs = session_.knobs();
  knobs.takesShortcuts = true;
  session_.setKnobs(knobs);
  ASSERT_TRUE(open("block"));
  const Panel& panel = session_.panel(1);
  for (int i = 0; i < 5; ++i) {
    knobs = session_.knobs();
    knobs.isFrozen = true;
    session_.setKnobs(knobs);
    ASSERT_NE(panel.shortcut, "");
    const double ofShortcut = panel.errors->flip;
    turn(session_, 10.0);
    ASSERT_TRUE(pumpUntil([&] { return panel.shortcut.empty(); }));
    EXPECT_TRUE(!panel.errorsAreCurrent || panel.errors->flip != ofShortcut);
    ASSERT_TRUE(pumpUntil([&] { return panel.errorsAreCurrent; }));
    EXPECT_NE(panel.errors->flip, ofShortcut);
    knobs.isFrozen = false;
    session_.setKnobs(knobs);
    ASSERT_TRUE(pumpUntil([&] { return !panel.shortcut.empty() && panel.errorsAreCurrent; }));
    ASSERT_TRUE(settle());
  }
}

TEST_F(SessionErrorsTest, WhereNoDeviceMarchesErrorsWaitUntilTheCameraRests) {
  ASSERT_TRUE(open("block"));
  EXPECT_FALSE(session_.groundTruth().followsCamera());
  const auto until = clock_.now() + milliseconds(500);
  while (clock_.now() < until) {
    move(1);
    EXPECT_FALSE(session_.panel(1).errorsAreCurrent);
    std::this_thread::sleep_for(milliseconds(1));
  }
  EXPECT_TRUE(settle());
}

TEST_F(SessionErrorsTest, TheFrontHasAPointForEachConfigurationThatWasSeen) {
  ASSERT_TRUE(open("block"));
  const LiveFront& front = session_.liveFront();
  ASSERT_TRUE(pumpUntil([&] { return front.points().size() == 2u; }));
  for (size_t i = 0; i < session_.panelCount(); ++i) {
    const auto& points = front.points();
    const auto point = std::find_if(points.begin(), points.end(), [&](const auto& one) { return one.configuration == *session_.panel(i).configuration; });
    ASSERT_NE(point, points.end()) << i;
    EXPECT_EQ(point->configuration.technique, session_.panel(i).technique);
    EXPECT_EQ(point->configuration.serverSidePx, 48u);
    EXPECT_EQ(point->pictureSize, session_.pictureSize());
    EXPECT_EQ(point->standing, LiveFront::Standing::ranked);
    EXPECT_DOUBLE_EQ(point->flip, session_.panel(i).errors->flip);
    EXPECT_EQ(point->buckets.front().fromDeg, 0.0);
    EXPECT_GT(point->frameMs, 0.0);
  }
  EXPECT_EQ(session_.panel(1).configuration->march.sample.heuristic, session_.knobs().march.sample.heuristic);

  freeze(session_);
  turn(session_, 24.0);
  ASSERT_TRUE(pumpUntil([&] { return front.rankedAnglesDeg().size() == 2u; }));
  EXPECT_EQ(front.rankedAnglesDeg(), (std::vector<double>{0.0, 22.5}));
  for (const LiveFront::Point& point : front.points()) EXPECT_EQ(point.buckets.size(), 2u);

  // All three can be compared where the third was seen.
  session_.setTechnique(1, findWarp("splats"));
  ASSERT_TRUE(pumpUntil([&] { return front.points().size() == 3u; }));
  EXPECT_EQ(front.rankedAnglesDeg().size(), 1u);
  EXPECT_EQ(front.rankedAnglesDeg().front(), 22.5);

  LiveSettings knobs = session_.knobs();
  knobs.isFrozen = false;
  knobs.march.sample.radiusPolicy = RadiusPolicy::constant;
  session_.setKnobs(knobs);
  ASSERT_TRUE(pumpUntil([&] { return front.points().size() == 4u; }));  // `hold` depends on no radius
  session_.load(builtin("shells"));
  ASSERT_TRUE(pumpUntil([&] { return session_.scene()->name == "shells"; }));
  EXPECT_TRUE(front.points().empty());
}

TEST_F(SessionErrorsTest, PointsOutliveAnotherSizeOfThePictures) {
  ASSERT_TRUE(open("block"));
  const LiveFront& front = session_.liveFront();
  ASSERT_TRUE(pumpUntil([&] { return front.front().size() > 0u && front.points().size() == 2u; }));
  const std::vector<size_t> before = front.front();
  const double flip = front.points()[1].flip;
  session_.setPanelSize({31, 29});
  session_.update(clock_.now());
  ASSERT_EQ(front.points().size(), 2u);
  for (const LiveFront::Point& point : front.points()) EXPECT_EQ(point.standing, LiveFront::Standing::otherSize);
  EXPECT_TRUE(front.front().empty());
  session_.setPanelSize(kPanelPx);
  session_.update(clock_.now());
  EXPECT_EQ(front.front(), before);  // at once
  EXPECT_EQ(front.points()[1].flip, flip);
}

/// While anything else is at work, here the other panel's judge, no picture is timed: how long it took would say what ran beside it.
TEST_F(SessionErrorsTest, PicturesAreTimedWhenNothingElseIsAtWork) {
  std::atomic<bool> mayEnd = false;
  std::atomic<int> begun = 0, done = 0;
  SessionSettings stuck = settings();
  stuck.makeJudge = [&]() -> JudgeFunction {
    return [&](const std::shared_ptr<const ReferenceImage>& reference, const WarpedImage& image, Image<float>& map) {
      const bool isFirst = begun++ == 0;
      while (isFirst && !mayEnd) std::this_thread::sleep_for(milliseconds(1));
      ++done;
      return reference->judge().errorsOf(image, nullptr, &map);
    };
  };
  Session session(stuck, [] {});
  session.setPanelSize(kPanelPx);
  session.load(builtin("block"));
  EXPECT_TRUE(pumpUntil(session, [&] { return begun >= 2 && done >= 1 && (session.panel(0).errors || session.panel(1).errors); }));
  const auto until = clock_.now() + milliseconds(1500);  // more than the quiet before a picture is timed
  while (clock_.now() < until) {
    session.update(clock_.now());
    std::this_thread::sleep_for(milliseconds(1));
  }
  EXPECT_TRUE(session.liveFront().points().empty());
  mayEnd = true;
  EXPECT_TRUE(pumpUntil(session, [&] { return session.liveFront().points().size() == 2u; }));
  EXPECT_TRUE(session.close(kPatience));
}

/// What moves is not timed, and what is being timed gives way at once.
TEST_F(SessionErrorsTest, AMovingCameraIsNotHeldUpByTiming) {
  LiveSettings knobs = session_.knobs();
  knobs.serverSidePx = 320;
  session_.setKnobs(knobs);
  session_.setPanelSize({320, 320});  // so that timing takes a while
  ASSERT_TRUE(open("block"));
  for (int i = 0; i < 6; ++i) {
    // At various moments after the rest: before, while and after pictures are timed.
    const auto until = clock_.now() + milliseconds(750 + 15 * i);
    while (clock_.now() < until) session_.update(clock_.now());
    const ShownPicture before = session_.panel(1).picture;
    turn(session_, 2.0);
    ASSERT_TRUE(pumpUntil([&] { return session_.panel(1).picture != before; })) << i;
    EXPECT_EQ(session_.panel(1).error, "");
  }
  ASSERT_TRUE(settle());
  ASSERT_TRUE(pumpUntil([&] { return session_.liveFront().points().size() == 2u; }));
  EXPECT_EQ(session_.error(), "");
}

TEST_F(SessionErrorsTest, AConfigurationThatIsChosenIsTakenOver) {
  ASSERT_TRUE(open("block"));
  Configuration wanted;
  wanted.technique = &findWarp("spheres");
  wanted.march = session_.knobs().march;
  wanted.march.sample.heuristic = Heuristic::median;
  wanted.march.sample.radiusPolicy = RadiusPolicy::pixel;
  wanted.march.sample.radiusScale = 2.0f;
  wanted.march.render.step = 0.75f;
  wanted.serverSidePx = 32;
  wanted.codec.color = ColorCoding::lossless;
  session_.choose(0, wanted);
  ASSERT_TRUE(pumpUntil([&] { return session_.panel(0).configuration == normalized(wanted) && session_.panel(0).errorsAreCurrent; }));
  EXPECT_EQ(session_.frames().newest()->camera.height, 32u);

  // What a technique does not depend on stays for the other panel.
  Configuration points{&findWarp("points"), {}, 48, {}, {}};
  points.knobs.set(kPointSizeKnob, 5);
  session_.choose(1, points);
  EXPECT_EQ(session_.knobs().warp.knobs.whole(kPointSizeKnob), 5);
  EXPECT_EQ(session_.knobs().march.sample.radiusPolicy, RadiusPolicy::pixel);
  EXPECT_EQ(session_.knobs().march.sample.radiusScale, 2.0f);
  EXPECT_EQ(session_.knobs().serverSidePx, 48u);
  EXPECT_EQ(session_.panel(1).technique, &findWarp("points"));

  // One of a sweep says nothing of what sweeps do not go through.
  LiveSettings knobs = session_.knobs();
  knobs.march.render.effects.mode = RenderMode::mip;
  session_.setKnobs(knobs);
  session_.choose(0, wanted, Session::Says::whatSweepsGoThrough);
  EXPECT_EQ(session_.knobs().march.render.effects.mode, RenderMode::mip);
  EXPECT_EQ(session_.knobs().march.render.step, 0.75f);
  session_.choose(0, wanted);
  EXPECT_EQ(session_.knobs().march.render.effects.mode, RenderMode::composite);
}

}  // namespace
}  // namespace warpscope
