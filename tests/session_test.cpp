// A whole session without a window: frames, pictures, ages, errors, closing.
// Mirrors app/session/session.h. Threads are real, volumes and images tiny.
#include "app/session/session.h"

#include "app/frames/frame_fetch.h"
#include "render/warp/arithmetic_knob.h"
#include "tests/session_fixture.h"

namespace warpscope {
namespace {

/// A technique that never succeeds.
class BrokenWarp final : public Warp {
 public:
  void setFrame(SampleFramePtr, const WarpSettings&, const std::stop_token&) override {}
  void draw(const Camera&, const WarpSettings&, WarpedImage&, const std::stop_token&) override { throw InputError("out of paint"); }
};
constexpr WarpDescriptor kBroken{
    .name = "broken",
    .label = "Broken",
    .summary = "Fails.",
    .make = [](const WarpResources&) -> std::unique_ptr<Warp> { return std::make_unique<BrokenWarp>(); },
};

TEST_F(SessionTest, BothPanelsShowTheNewestFrame) {
  ASSERT_TRUE(open("block"));
  ASSERT_NE(session_.scene(), nullptr);
  EXPECT_EQ(session_.scene()->name, "block");
  EXPECT_EQ(session_.loading(), "");
  ASSERT_TRUE(session_.frames().newest());
  EXPECT_GT(session_.frames().newest()->size(), 0u);
  EXPECT_EQ(session_.frames().newest()->camera.height, 48u);  // the longer side
  for (size_t i = 0; i < session_.panelCount(); ++i) {
    EXPECT_EQ(session_.panel(i).requestId, session_.frames().newest()->requestId);
    EXPECT_EQ(session_.panel(i).picture.width(), kPanelPx.x);
    EXPECT_EQ(session_.panel(i).picture.height(), kPanelPx.y);
    EXPECT_EQ(session_.panel(i).error, "");
  }
  EXPECT_GT(news_, 0);
}

TEST_F(SessionTest, AMovementBringsANewFrameAndNewErrors) {
  ASSERT_TRUE(open("block"));
  const uint64_t before = session_.frames().newest()->requestId;
  View view = session_.view();
  view.angleDeg += 30.0;
  session_.setView(view);
  session_.update(clock_.now());
  EXPECT_FALSE(session_.panel(0).errorsAreCurrent);
  EXPECT_TRUE(session_.panel(0).errors.has_value());  // the last value stays, greyed
  ASSERT_TRUE(settle());
  EXPECT_GT(session_.frames().newest()->requestId, before);
}

TEST_F(SessionTest, AFrozenFrameStaysAndAges) {
  ASSERT_TRUE(open("block"));
  const SampleFramePtr frame = session_.frames().newest();
  const double holesAtHome = session_.panel(1).errors->holeFraction;
  LiveSettings knobs = session_.knobs();
  knobs.isFrozen = true;
  session_.setKnobs(knobs);
  View view = session_.view();
  view.angleDeg += 60.0;
  session_.setView(view);
  const Clock::TimePoint moved = clock_.now();
  session_.update(moved);
  EXPECT_EQ(session_.ageMs(1, moved + milliseconds(100)), 100.0);
  view.angleDeg += 1.0;
  session_.setView(view);
  session_.update(moved + milliseconds(10));
  EXPECT_EQ(session_.ageMs(1, moved + milliseconds(100)), 100.0);  // since it was left first

  ASSERT_TRUE(pumpUntil([&] { return session_.panel(1).errorsAreCurrent; }));
  EXPECT_EQ(session_.frames().newest(), frame);
  EXPECT_GT(session_.panel(1).errors->holeFraction, holesAtHome);  // what was hidden is seen from here

  knobs.isFrozen = false;
  session_.setKnobs(knobs);
  ASSERT_TRUE(settle());
  EXPECT_NE(session_.frames().newest(), frame);
}

TEST_F(SessionTest, ComingBackToTheFramesCameraMakesItCurrentAgain) {
  ASSERT_TRUE(open("block"));
  LiveSettings knobs = session_.knobs();
  knobs.isFrozen = true;
  session_.setKnobs(knobs);
  const View home = session_.view();
  const ShownPicture pictureAtHome = session_.panel(0).picture;
  View view = home;
  view.distance *= 1.1;
  session_.setView(view);
  session_.update(clock_.now());
  EXPECT_GT(*session_.ageMs(0, clock_.now() + seconds(1)), 0.0);
  session_.setView(home);
  session_.update(clock_.now());
  EXPECT_EQ(session_.ageMs(0, clock_.now() + seconds(1)), 0.0);
  EXPECT_EQ(session_.panel(0).errorsAreCurrent, session_.panel(0).picture == pictureAtHome);  // else they are measured anew
  EXPECT_TRUE(settle());
}

/// Both shortcuts, in a session that takes them: what panels say of their pictures, and what they did.
TEST_F(SessionTest, ShortcutsTakeTheTechniquesPlaceAndSaySo) {
  LiveSettings knobs = session_.knobs();
  ASSERT_FALSE(knobs.takesShortcuts) << "off unless somebody wants them";
  knobs.takesShortcuts = true;
  knobs.transport.codec.color = ColorCoding::lossless;
  knobs.serverSidePx = kPanelPx.y;  // the server's image is as large as the panels' pictures
  session_.setKnobs(knobs);
  ASSERT_TRUE(open("block"));
  const auto shown = [&](size_t i) -> const Panel& { return session_.panel(i); };
  for (size_t i = 0; i < session_.panelCount(); ++i) {
    EXPECT_EQ(shown(i).shortcut, "the frame's own picture");
    EXPECT_EQ(shown(i).counts, (WarpCounts{.shortcuts = shown(i).counts.shortcuts})) << "no technique was at work";
    EXPECT_GE(shown(i).counts.shortcuts, 1u);
    EXPECT_FALSE(shown(i).configuration) << "nobody's point in the plot";
    EXPECT_LT(shown(i).errors->flip, 0.01) << "that of 8 bits";
  }
  EXPECT_TRUE(shown(0).errors->flip == shown(1).errors->flip);
  // Nothing happens any more, and nothing is timed: longer than it takes until pictures are (PictureTiming).
  const std::array<WarpCounts, 2> counts{shown(0).counts, shown(1).counts};
  const auto rest = clock_.now() + milliseconds(1200);
  ASSERT_TRUE(pumpUntil([&] { return clock_.now() > rest; }));
  for (size_t i = 0; i < session_.panelCount(); ++i) EXPECT_EQ(shown(i).counts, counts[i]);
  EXPECT_EQ(session_.liveFront().remembered(), 0u);

  // An image of another size has the same eye.
  knobs = session_.knobs();
  knobs.serverSidePx = 48;
  session_.setKnobs(knobs);
  const std::string turnedText(shortcutText(PictureWay::rotation));
  ASSERT_TRUE(pumpUntil([&] { return shown(0).shortcut == turnedText && shown(1).shortcut == turnedText; }));
  ASSERT_TRUE(settle());
  EXPECT_EQ(shown(1).counts.draws, 0u);

  // A camera elsewhere wants the techniques.
  knobs.isFrozen = true;
  session_.setKnobs(knobs);
  View view = session_.view();
  for (int i = 0; i < 3; ++i) {
    view.angleDeg += 5.0;
    session_.setView(view);
    const uint64_t draws = shown(1).counts.draws;
    ASSERT_TRUE(pumpUntil([&] { return shown(1).counts.draws > draws && shown(1).errorsAreCurrent; }));
    EXPECT_EQ(shown(1).shortcut, "");
  }
  EXPECT_EQ(shown(1).counts.made, 1u);
  EXPECT_EQ(shown(1).counts.builds, 1u);
  EXPECT_EQ(shown(1).counts.draws, 3u);
  EXPECT_TRUE(shown(1).configuration);
  EXPECT_GT(session_.liveFront().remembered(), 0u);
  knobs = session_.knobs();
  knobs.isFrozen = knobs.takesShortcuts = false;
  session_.setKnobs(knobs);
  ASSERT_TRUE(pumpUntil([&] { return shown(0).configuration && shown(1).configuration; }));
  // Counts are a scene's.
  ASSERT_TRUE(open("shells"));
  EXPECT_LT(shown(1).counts.builds, 3u);
  EXPECT_EQ(shown(1).counts.made, 1u);
  EXPECT_EQ(shown(1).counts.shortcuts, 0u);
}

TEST_F(SessionTest, EachPanelHasItsOwnArithmetic) {
  ASSERT_TRUE(open("block"));
  session_.setTechnique(0, findWarp("reference"));
  session_.setTechnique(1, findWarp("reference"));
  KnobValues knobs = session_.panel(1).knobs;
  ASSERT_TRUE(settle());
  const auto turn = [&](Arithmetic arithmetic) {
    const ShownPicture before = session_.panel(1).picture;
    knobs.set(kArithmeticKnob, arithmetic);
    session_.setPanelKnobs(1, knobs);
    return pumpUntil([&] { return !(session_.panel(1).picture == before) && session_.panel(1).errorsAreCurrent; });
  };
  ASSERT_TRUE(turn(Arithmetic::textbook));
  // The ground truth is stable, whatever a panel shows.
  EXPECT_EQ(session_.panel(0).errors->flip, 0.0);
  EXPECT_GT(session_.panel(1).errors->flip, 0.0);
  ASSERT_TRUE(turn(Arithmetic::stable));
  EXPECT_EQ(session_.panel(1).errors->flip, 0.0);
}

TEST_F(SessionTest, ATechniqueChosenBackAtOnceIsStillDrawn) {
  ASSERT_TRUE(open("block"));
  View view = session_.view();
  view.angleDeg += 40.0;
  session_.setView(view);
  session_.update(clock_.now());  // a job is on its way
  session_.setTechnique(0, findWarp("spheres"));
  session_.setTechnique(0, findWarp("hold"));
  EXPECT_TRUE(settle());
}

TEST_F(SessionTest, TechniquesChangeOnePanel) {
  ASSERT_TRUE(open("block"));
  session_.setTechnique(0, findWarp("reference"));
  ASSERT_TRUE(settle());
  EXPECT_EQ(session_.panel(0).drawn->name, "reference");
  EXPECT_EQ(session_.panel(1).drawn->name, "spheres");
  EXPECT_EQ(session_.ageMs(0, clock_.now()), std::nullopt);  // it shows no frame
}

TEST_F(SessionTest, UncoveredPixelsGetTheirColor) {
  ASSERT_TRUE(open("block"));
  LiveSettings knobs = session_.knobs();
  knobs.marks.uncovered = 0xffff00ffu;
  session_.setKnobs(knobs);
  ASSERT_TRUE(pumpUntil([&] { return (*session_.panel(1).picture.host)(0, 0) == 0xffff00ffu; }));
}

TEST_F(SessionTest, AStormOfSizesEndsWithTheLastOne) {
  ASSERT_TRUE(open("block"));
  const auto began = clock_.now();
  for (uint32_t i = 0; i < 1000; ++i) {
    session_.setPanelSize({1 + i % 83, 1 + i % 59});
    session_.update(clock_.now());
  }
  EXPECT_LT(clock_.now() - began, seconds(10));  // nothing waits for pictures or frames
  session_.setPanelSize({57, 33});
  ASSERT_TRUE(settle());
  for (size_t i = 0; i < session_.panelCount(); ++i) {
    EXPECT_EQ(session_.panel(i).picture.width(), 57u);
    EXPECT_EQ(session_.panel(i).picture.height(), 33u);
  }
  EXPECT_LE(session_.frames().remembered(), 4u);
}

TEST_F(SessionTest, TheStagesOfAFrameAreKnownWhereItIsShown) {
  ASSERT_TRUE(open("shells"));
  LiveSettings knobs = session_.knobs();
  knobs.transport.link.up.delayMs = 30.0;
  knobs.transport.link.down.delayMs = 30.0;
  session_.setKnobs(knobs);
  session_.update(clock_.now());
  std::this_thread::sleep_for(milliseconds(50));  // the link takes effect for what is sent from now on
  move(1);
  ASSERT_TRUE(settle());
  const Panel& panel = session_.panel(1);
  EXPECT_GE(panel.latency.wireMs, 59.0);
  EXPECT_GT(panel.latency.marchMs, 0.0);
  EXPECT_GT(panel.latency.encodeMs, 0.0);
  EXPECT_GT(panel.latency.decodeMs, 0.0);
  EXPECT_GT(panel.bytes, size_t{0});
  EXPECT_EQ(panel.bytes, session_.frames().bytesOfNewest().samples);
  const std::optional<SourceStatus> status = session_.sourceStatus();
  ASSERT_TRUE(status);
  EXPECT_TRUE(status->isConnected) << status->sentence;
  EXPECT_NE(status->where.find("127.0.0.1:"), std::string::npos);
}

TEST_F(SessionTest, PanelsSayWhatTheirTechniqueDrawsOfTheFrame) {
  ASSERT_TRUE(open("block"));
  const auto bytesOf = [&](std::string_view technique) {
    session_.setTechnique(1, findWarp(technique));
    EXPECT_TRUE(settle());
    return session_.panel(1);
  };
  // The frame's picture alone, as a viewer that streams pictures is sent it: found with the errors.
  const Panel& hold = session_.panel(0);
  ASSERT_TRUE(hold.bytes);
  EXPECT_EQ(*hold.bytes, pictureBytes(session_.frames().newest(), session_.scene()->background, session_.knobs().transport.codec));
  EXPECT_EQ(hold.proxyBytes, 0u);
  const Panel spheres = bytesOf("spheres");
  EXPECT_EQ(spheres.bytes, session_.frames().bytesOfNewest().samples);
  EXPECT_EQ(spheres.proxyBytes, 0u);
  const Panel segments = bytesOf("segments");
  const FrameBytes whole = session_.frames().bytesOfNewest();
  EXPECT_GT(whole.segments, 0u);
  EXPECT_EQ(segments.bytes, whole.segments);
  EXPECT_EQ(segments.proxyBytes, whole.proxy);
  EXPECT_GT(whole.proxy, 0u);
  // It came once, and goes with every frame from then on.
  const uint64_t before = session_.frames().newest()->requestId;
  turn(session_, 20.0);
  ASSERT_TRUE(settle());
  ASSERT_GT(session_.frames().newest()->requestId, before);
  EXPECT_EQ(session_.panel(1).proxyBytes, whole.proxy);
  const Panel proxy = bytesOf("proxy");
  EXPECT_EQ(proxy.bytes, size_t{0});
  EXPECT_EQ(proxy.proxyBytes, whole.proxy);
}

TEST_F(SessionTest, ATechniqueWithNothingToDrawSaysSoAndGetsNoPoint) {
  ASSERT_TRUE(open("block"));
  LiveSettings knobs = session_.knobs();
  knobs.march.sample.segments = 0;
  session_.setKnobs(knobs);
  session_.setTechnique(1, findWarp("segments"));
  ASSERT_TRUE(settle());
  EXPECT_EQ(session_.panel(1).lack, "there are no segments (--segments 0)");
  EXPECT_FALSE(session_.panel(1).configuration);
  EXPECT_EQ(session_.panel(0).lack, "");
  knobs.march.sample.segments = 3;
  session_.setKnobs(knobs);
  ASSERT_TRUE(pumpUntil([&] { return session_.panel(1).lack.empty(); }));
}

TEST_F(SessionTest, AServerThatFailsIsASentenceAndRecovers) {
  ASSERT_TRUE(open("block"));
  LiveSettings knobs = session_.knobs();
  const float step = knobs.march.render.step;
  knobs.march.render.step = 0.0f;
  session_.setKnobs(knobs);
  ASSERT_TRUE(pumpUntil([&] { return !session_.error().empty(); }));
  EXPECT_THAT(session_.error(), ::testing::HasSubstr("step"));
  knobs.march.render.step = 2.0f * step;
  session_.setKnobs(knobs);
  ASSERT_TRUE(settle());
  EXPECT_EQ(session_.error(), "");
}

TEST_F(SessionTest, AGroundTruthThatFailsIsASentenceAndRecovers) {
  faults_->render = true;
  session_.load(builtin("block"));
  ASSERT_TRUE(pumpUntil([&] { return !session_.error().empty(); }));
  EXPECT_EQ(session_.error(), "no ground truth today");
  session_.dismissErrors();
  EXPECT_EQ(session_.error(), "");
  move(1);
  ASSERT_TRUE(pumpUntil([&] { return !session_.error().empty(); }));
  faults_->render = false;
  move(1);
  ASSERT_TRUE(settle());
  EXPECT_EQ(session_.error(), "");
}

/// One frame is on show from before; ages of requests that failed are of no use to anybody.
TEST_F(SessionTest, AServerThatKeepsFailingIsForgotten) {
  ASSERT_TRUE(open("block"));
  const double ageBefore = *session_.ageMs(0, clock_.now());
  faults_->march = true;
  move(1);
  const Clock::TimePoint moved = clock_.now();
  move(4000);
  ASSERT_TRUE(pumpUntil([&] { return !session_.frames().isUnderWay(); }));
  EXPECT_EQ(session_.error(), "the server is on fire");
  EXPECT_LE(session_.frames().remembered(), 2u);
  EXPECT_EQ(ageBefore, 0.0);
  EXPECT_GE(*session_.ageMs(0, moved + seconds(1)), 1000.0);  // what is on show is still known to be old

  faults_->march = false;
  move(1);
  ASSERT_TRUE(settle());
}

TEST_F(SessionTest, ATechniqueThatKeepsFailingIsForgotten) {
  ASSERT_TRUE(open("block"));
  session_.setTechnique(1, kBroken);
  for (int i = 0; i < 40; ++i) {
    const uint64_t before = session_.frames().newest()->requestId;
    move(100);
    ASSERT_TRUE(pumpUntil([&] { return session_.frames().newest()->requestId > before && !session_.frames().isUnderWay(); }));
  }
  ASSERT_TRUE(pumpUntil([&] { return session_.frames().remembered() <= 3; }));  // each panel's, and the newest
  EXPECT_EQ(session_.panel(1).error, "out of paint");
  EXPECT_NE(session_.ageMs(1, clock_.now()), 0.0);  // its last picture is from long ago
  session_.setTechnique(1, findWarp("spheres"));
  ASSERT_TRUE(settle());
}

TEST_F(SessionTest, AViewThatCannotBeShownIsASentenceAndTheLastOneStays) {
  ASSERT_TRUE(open("block"));
  const View home = session_.view();
  View view = home;
  view.distance = 1e30;
  session_.setView(view);
  ASSERT_TRUE(settle());
  EXPECT_NE(session_.error(), "");
  EXPECT_EQ(session_.view(), home);
  view = home;
  view.angleDeg += 5.0;
  session_.setView(view);
  ASSERT_TRUE(settle());
  EXPECT_EQ(session_.error(), "");
}

TEST_F(SessionTest, LargePanelsDrawCoarserPixelsUnlessToldOtherwise) {
  EXPECT_EQ(session_.screenPixels(), 1u);
  session_.setPanelSize({1900, 2000});
  EXPECT_GT(session_.screenPixels(), 1u);
  LiveSettings knobs = session_.knobs();
  knobs.screenPixels = 1;
  session_.setKnobs(knobs);
  EXPECT_EQ(session_.pictureSize(), glm::uvec2(1900, 2000));
  EXPECT_EQ(session_.serverSize(), glm::uvec2(46, 48));
}

TEST_F(SessionTest, NothingHappensWithoutAScene) {
  EXPECT_FALSE(session_.update(clock_.now()));
  EXPECT_EQ(session_.scene(), nullptr);
  session_.resetView();
  EXPECT_EQ(session_.ageMs(0, clock_.now()), std::nullopt);
}

TEST_F(SessionTest, ClosesInTheMiddleOfEverything) {
  for (int i = 0; i < 20; ++i) {
    Session session(settings(), [] {});
    session.setPanelSize({400, 400});
    session.load(builtin(i % 2 == 0 ? "block" : "shells"));
    const auto until = clock_.now() + milliseconds(7 * i);
    View view;
    while (clock_.now() < until) {
      view.angleDeg += 1.0;
      session.setView(view);
      session.update(clock_.now());
    }
    EXPECT_TRUE(session.close(kPatience));
  }
}

}  // namespace
}  // namespace warpscope
