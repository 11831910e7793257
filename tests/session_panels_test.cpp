// Panels that come, go, move, hide, and look from elsewhere: mirrors the parts of app/session/session.h that are about them.
#include "app/session/actions.h"
#include "tests/session_fixture.h"

namespace warpscope {
namespace {

using SessionPanelsTest = SessionTest;

std::vector<std::string_view> techniquesOf(const Session& session) {
  std::vector<std::string_view> names;
  for (size_t i = 0; i < session.panelCount(); ++i) names.push_back(session.panel(i).technique->name);
  return names;
}

TEST_F(SessionPanelsTest, SixAtMostAndOneAtLeast) {
  ASSERT_TRUE(open("block"));
  const PanelSettings points{.technique = &findWarp("points")};
  for (size_t count = 3; count <= kMaxPanels; ++count) EXPECT_TRUE(session_.addPanel(points));
  EXPECT_FALSE(session_.addPanel(points));
  ASSERT_EQ(session_.panelCount(), kMaxPanels);
  ASSERT_TRUE(settle()) << "all six show the current camera";
  for (size_t i = 1; i < kMaxPanels; ++i) {
    EXPECT_EQ(session_.panel(i).requestId, session_.panel(0).requestId) << "the same frame";
    EXPECT_NE(session_.panel(i).id, session_.panel(0).id);
  }
  while (session_.panelCount() > 1) {
    ASSERT_TRUE(session_.removePanel(0));
    session_.update(clock_.now());
  }
  EXPECT_FALSE(session_.removePanel(0));
  EXPECT_EQ(session_.panel(0).technique->name, "points");
  ASSERT_TRUE(settle());
}

TEST_F(SessionPanelsTest, OneThatIsAtWorkGoesWithoutAWait) {
  ASSERT_TRUE(open("shells"));
  turn(session_, 5.0);
  session_.update(clock_.now());
  const auto began = clock_.now();
  ASSERT_TRUE(session_.removePanel(1));
  EXPECT_LT(clock_.now() - began, milliseconds(100));
  ASSERT_TRUE(settle());
  EXPECT_TRUE(session_.close(seconds(20)));
}

TEST_F(SessionPanelsTest, AMovedPanelTakesItsPictureAlong) {
  ASSERT_TRUE(open("block"));
  ASSERT_TRUE(session_.addPanel({.technique = &findWarp("points")}));
  ASSERT_TRUE(settle());
  const uint64_t first = session_.panel(0).id;
  const ShownPicture picture = session_.panel(0).picture;
  session_.movePanel(0, 2);
  EXPECT_EQ(techniquesOf(session_), (std::vector<std::string_view>{"spheres", "points", "hold"}));
  EXPECT_EQ(session_.panel(2).id, first);
  EXPECT_EQ(session_.panel(2).picture, picture);
  session_.movePanel(2, 1);
  EXPECT_EQ(techniquesOf(session_), (std::vector<std::string_view>{"spheres", "hold", "points"}));
  turn(session_, 10.0);
  ASSERT_TRUE(settle());
  EXPECT_NE(session_.panel(1).picture, picture);
}

TEST_F(SessionPanelsTest, AHiddenOneIsNeitherDrawnNorWaitedFor) {
  ASSERT_TRUE(open("block"));
  session_.setHidden(0, true);
  const ShownPicture before = session_.panel(0).picture;
  const uint64_t draws = session_.panel(0).counts.draws;
  turn(session_, 10.0);
  ASSERT_TRUE(settle());
  EXPECT_EQ(session_.panel(0).picture, before);
  EXPECT_EQ(session_.panel(0).counts.draws, draws);
  session_.setHidden(0, false);
  ASSERT_TRUE(settle());
  EXPECT_NE(session_.panel(0).picture, before);
}

TEST_F(SessionPanelsTest, AnOwnCameraTurnsItsPanelAloneAndIsJudgedForItself) {
  ASSERT_TRUE(open("block"));
  session_.setOwnCamera(1, true);
  EXPECT_EQ(session_.view(1), session_.view(0)) << "it begins where all are";
  ASSERT_TRUE(settle());
  const double atHome = session_.panel(1).errors->flip;
  const ShownPicture left = session_.panel(0).picture;
  const uint64_t frame = session_.frames().newest()->requestId;
  View view = session_.view(1);
  view.angleDeg += 40.0;
  session_.setView(1, view);
  ASSERT_TRUE(pumpUntil([&] {
    return session_.panel(1).errorsAreCurrent && session_.groundTruth(1).image() &&
           session_.groundTruth(1).image()->job().camera == session_.groundTruth(1).wanted().camera;
  }));
  EXPECT_EQ(session_.panel(0).picture, left);
  EXPECT_NE(session_.view(1), session_.view(0));
  EXPECT_EQ(session_.frames().newest()->requestId, frame) << "the server sees what the others see";
  EXPECT_NE(session_.panel(1).errors->flip, atHome) << "from 40 degrees away";
  EXPECT_NE(session_.groundTruth(1).image()->color(), session_.groundTruth(0).image()->color());
  session_.resetView(1);
  EXPECT_EQ(session_.view(1), session_.scene()->views.front());
  session_.setView(1, view);
  session_.setOwnCamera(1, false);
  EXPECT_EQ(session_.view(1), session_.view(0));
  ASSERT_TRUE(settle());
  EXPECT_EQ(session_.panel(1).errors->flip, atHome);
}

TEST_F(SessionPanelsTest, AnImpossibleOwnViewGivesWayToTheLast) {
  ASSERT_TRUE(open("block"));
  session_.setOwnCamera(1, true);
  ASSERT_TRUE(settle());
  const View good = session_.view(1);
  View bad = good;
  bad.distance = std::numeric_limits<double>::quiet_NaN();
  session_.setView(1, bad);
  session_.update(clock_.now());
  EXPECT_EQ(session_.view(1), good);
  EXPECT_FALSE(session_.error().empty());
  session_.dismissErrors();
  EXPECT_TRUE(session_.error().empty());
}

TEST_F(SessionPanelsTest, StayAsTheyAreWithAnotherScene) {
  ASSERT_TRUE(open("block"));
  session_.setContent(1, PictureContent::holes, 0.5f);
  session_.setOwnCamera(0, true);
  const uint64_t id = session_.panel(1).id;
  ASSERT_TRUE(open("shells"));
  EXPECT_EQ(session_.panel(1).id, id);
  EXPECT_EQ(session_.panel(1).content, PictureContent::holes);
  EXPECT_TRUE(session_.hasOwnCamera(0));
  EXPECT_EQ(session_.view(0), session_.scene()->views.front());
}

/// Where a panel's picture shows a sample, as near to its middle as there is one, and where it does not.
struct Places {
  std::optional<glm::dvec2> sample, other;
};
Places placesIn(const Panel& panel) {
  Places places;
  const PanelPixels& pixels = *panel.currentPixels();
  const Image<uint32_t>& samples = pixels.image->samples;
  for (uint32_t y = 0; y < samples.height(); ++y)
    for (uint32_t x = 0; x < samples.width(); ++x) {
      const glm::dvec2 place((x + 0.5) / samples.width(), (y + 0.5) / samples.height());
      if (samples(x, y) >= pixels.frame->size())
        places.other = place;
      else if (!places.sample || glm::distance(place, glm::dvec2(0.5)) < glm::distance(*places.sample, glm::dvec2(0.5)))
        places.sample = place;
    }
  return places;
}

TEST_F(SessionPanelsTest, ARayIsLookedAtAndFollowsKnobs) {
  ASSERT_TRUE(open("shells"));
  ASSERT_NE(session_.panel(1).currentPixels(), nullptr);
  const Places places = placesIn(session_.panel(1));
  ASSERT_TRUE(places.sample && places.other);
  session_.lookAt(LookedAt{session_.panel(1).id, *places.sample});
  ASSERT_TRUE(pumpUntil([&] { return session_.ray().isCurrent(); }));
  const RayResult first = *session_.ray().result();
  EXPECT_TRUE(first.job.ray.isServers);
  EXPECT_FALSE(first.trace.samples.empty());
  EXPECT_TRUE(depthBy(first.trace, Heuristic::gradient));

  LiveSettings knobs = session_.knobs();
  knobs.march.sample.threshold = 0.02f;
  knobs.march.sample.heuristic = Heuristic::threshold;
  session_.setKnobs(knobs);
  ASSERT_TRUE(pumpUntil([&] { return session_.ray().isCurrent() && session_.ray().result()->job.settings.sample.threshold == 0.02f; }));
  EXPECT_NE(depthBy(session_.ray().result()->trace, Heuristic::threshold), depthBy(first.trace, Heuristic::threshold));

  session_.lookAt(LookedAt{session_.panel(1).id, *places.other});
  ASSERT_TRUE(pumpUntil([&] { return session_.ray().isCurrent() && !session_.ray().result()->job.ray.isServers; }));
  session_.removePanel(1);
  session_.update(clock_.now());
  EXPECT_FALSE(session_.lookedAt()) << "its panel is gone";
  EXPECT_FALSE(session_.ray().result());
}

TEST_F(SessionPanelsTest, ASampleThatIsSeenThroughAGapIsToldFromOthers) {
  ASSERT_TRUE(open("shells"));
  session_.setTechnique(1, findWarp("points"));
  ASSERT_TRUE(settle());
  ASSERT_NE(session_.panel(1).currentPixels(), nullptr);
  const Places places = placesIn(session_.panel(1));
  ASSERT_TRUE(places.sample);
  session_.lookAt(LookedAt{session_.panel(1).id, *places.sample});
  ASSERT_TRUE(pumpUntil([&] { return session_.ray().isCurrent(); }));
  EXPECT_FALSE(session_.ray().result()->missed) << "seen from where the frame saw it";
  LiveSettings knobs = session_.knobs();
  knobs.isFrozen = true;
  session_.setKnobs(knobs);
  turn(session_, 60.0);
  ASSERT_TRUE(pumpUntil([&] { return session_.panel(1).currentPixels() != nullptr && session_.panel(1).errorsAreCurrent; }));
  const PanelPixels pixels = *session_.panel(1).currentPixels();
  const Image<uint32_t>& samples = pixels.image->samples;
  size_t looked = 0, missed = 0, covered = 0;
  for (uint32_t y = 0; y < samples.height(); ++y)
    for (uint32_t x = 0; x < samples.width(); ++x) {
      if (samples(x, y) >= pixels.frame->size() || ++looked % 23 != 0) continue;
      session_.lookAt(LookedAt{session_.panel(1).id, glm::dvec2((x + 0.5) / samples.width(), (y + 0.5) / samples.height())});
      ASSERT_TRUE(pumpUntil([&] { return session_.ray().isCurrent(); }));
      const std::optional<MissedPlace>& found = session_.ray().result()->missed;
      if (!found) continue;
      ++(found->before > 0.0f ? missed : covered);
      EXPECT_GT(std::abs(found->before), 2.0f);
      EXPECT_GT(found->depth, 0.0f);
    }
  EXPECT_GT(missed, 0u);
  EXPECT_LT(missed + covered, looked / 23) << "others are of the surface that is in front";
}

TEST(WindowActions, EveryRowStandsAtItsPlaceWithKeysOfItsOwn) {
  std::set<std::string> seen;
  for (const ActionDescriptor& action : windowActions()) {
    EXPECT_EQ(&describe(action.action), &action);
    EXPECT_FALSE(action.help.empty() || action.help.ends_with('.')) << action.label;
    for (const KeyChord& chord : chordsOf(action)) {
      const std::string text = (chord.isControl ? "Ctrl+" : "") + std::string(chord.isShift ? "Shift+" : "") + chord.name;
      EXPECT_TRUE(seen.insert(text).second) << text << " does two things";
      if (!action.isHeld) {
        EXPECT_EQ(actionOf(chord), action.action) << text;
      }
    }
  }
}

TEST(WindowActions, KeysAreReadAsTheyAreWritten) {
  EXPECT_EQ(actionOf({.name = "Q", .isControl = true}), Action::quit);
  EXPECT_EQ(actionOf({.name = "Q"}), std::nullopt);
  EXPECT_EQ(actionOf({.name = "F"}), Action::freeze);
  EXPECT_EQ(actionOf({.name = "F", .isControl = true}), Action::searchKnob);
  EXPECT_EQ(actionOf({.name = "F", .isAlt = true}), std::nullopt);
  EXPECT_EQ(actionOf({.name = "?", .isShift = true}), Action::help) << "as most keyboards type it";
  EXPECT_EQ(actionOf({.name = "F1"}), Action::help);
  EXPECT_EQ(actionOf({.name = "7"}), Action::chooseTechnique);
  EXPECT_EQ(actionOf({.name = "0"}), Action::chooseAutomatic);
  EXPECT_EQ(actionOf({.name = "B"}), std::nullopt) << "is held";
}

}  // namespace
}  // namespace warpscope
