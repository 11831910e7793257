// What a hand has set is taken back step by step, and named.
// Mirrors app/session/edit_history.h.
#include "app/session/edit_history.h"

#include <gtest/gtest.h>

#include "render/warp/kept_frames.h"
#include "tests/session_fixture.h"

namespace warpscope {
namespace {

class EditHistoryTest : public SessionTest {
 protected:
  void SetUp() override {
    ASSERT_TRUE(open("block"));
    curves_ = curvesOf(session_.scene()->transferFunction);
    follow();
  }
  void follow(bool isHeld = false) { history_.follow(session_, &curves_, isHeld); }
  void setSide(uint32_t side) {
    LiveSettings knobs = session_.knobs();
    knobs.serverSidePx = side;
    session_.setKnobs(knobs);
  }
  void show(const std::optional<EditState>& state) {
    ASSERT_TRUE(state);
    apply(*state, session_);
    curves_ = *state->curves;
    follow();
  }
  void undo() { show(history_.undo()); }
  void redo() { show(history_.redo()); }

  EditHistory history_;
  TransferCurves curves_;
};

TEST_F(EditHistoryTest, StepsAreTakenBackAndMadeAgain) {
  EXPECT_FALSE(history_.undo());
  EXPECT_EQ(history_.undoes(), "");
  const uint32_t first = session_.knobs().serverSidePx;
  setSide(128);
  follow();
  EXPECT_EQ(history_.undoes(), "Server image");
  setSide(256);
  follow();
  undo();
  EXPECT_EQ(session_.knobs().serverSidePx, 128u);
  undo();
  EXPECT_EQ(session_.knobs().serverSidePx, first);
  EXPECT_EQ(history_.undoes(), "");
  EXPECT_EQ(history_.redoes(), "Server image");
  redo();
  redo();
  EXPECT_EQ(session_.knobs().serverSidePx, 256u);
  EXPECT_EQ(history_.redoes(), "");
  undo();
  setSide(384);
  follow();
  EXPECT_EQ(history_.redoes(), "") << "another step was made instead";
  undo();
  EXPECT_EQ(session_.knobs().serverSidePx, 128u);
}

TEST_F(EditHistoryTest, WhatChangesWhileSomethingIsHeldIsOneStep) {
  const uint32_t first = session_.knobs().serverSidePx;
  for (const uint32_t side : {100u, 110u, 120u}) {
    setSide(side);
    follow(true);
  }
  EXPECT_EQ(history_.undoes(), "");
  follow();
  undo();
  EXPECT_EQ(session_.knobs().serverSidePx, first);
}

TEST_F(EditHistoryTest, PanelsComeBackWithWhatWasChosenForThem) {
  session_.setTechnique(1, findWarp("points"));
  follow();
  EXPECT_EQ(history_.undoes(), "technique of panel 2");
  KnobValues knobs = session_.panel(1).knobs;
  knobs.set(kKeepKnob, 3.0);
  session_.setPanelKnobs(1, knobs);
  follow();
  EXPECT_EQ(history_.undoes(), std::string(kKeepKnob.label) + " of panel 2");
  session_.setContent(0, PictureContent::depth);
  follow();
  EXPECT_EQ(history_.undoes(), "content of panel 1");
  session_.removePanel(1);
  follow();
  EXPECT_EQ(history_.undoes(), "panels");
  undo();
  ASSERT_EQ(session_.panelCount(), 2u);
  EXPECT_EQ(session_.panel(1).technique->name, "points");
  EXPECT_EQ(session_.panel(1).knobs[kKeepKnob], 3.0);
  undo();
  EXPECT_EQ(session_.panel(0).content, PictureContent::picture);
  undo();
  EXPECT_EQ(session_.panel(1).knobs[kKeepKnob], kKeepKnob.defaultValue);
}

TEST_F(EditHistoryTest, PanelsKeepTheirCamerasWhereOthersComeBackOrTheirOrderDoes) {
  session_.setTechnique(0, findWarp("points"));
  session_.setTechnique(1, findWarp("segments"));
  session_.setOwnCamera(1, true);
  follow();
  const uint64_t points = session_.panel(0).id, segments = session_.panel(1).id;
  session_.movePanel(0, 1);
  follow();
  EXPECT_EQ(history_.undoes(), "order of the panels");
  session_.removePanel(1);
  follow();
  undo();
  ASSERT_EQ(session_.panelCount(), 2u);
  EXPECT_EQ(session_.panel(0).id, segments);
  EXPECT_EQ(session_.panel(1).id, points) << "the same one comes back";
  EXPECT_TRUE(session_.hasOwnCamera(0));
  EXPECT_FALSE(session_.hasOwnCamera(1));
  undo();
  EXPECT_EQ(session_.panel(0).technique->name, "points");
  EXPECT_FALSE(session_.hasOwnCamera(0));
  EXPECT_TRUE(session_.hasOwnCamera(1));
  redo();
  redo();
  ASSERT_EQ(session_.panelCount(), 1u);
  EXPECT_EQ(session_.panel(0).id, segments);
}

TEST_F(EditHistoryTest, AllPanelsMayBeOthers) {
  while (session_.panelCount() < kMaxPanels) session_.addPanel({.technique = &findWarp("hold")});
  follow();
  const EditState full = *[&] {
    session_.removePanel(0);
    follow();
    return history_.undo();
  }();
  while (session_.panelCount() > 1) session_.removePanel(0);
  session_.addPanel({.technique = &findWarp("mesh")});
  session_.removePanel(0);  // none of those that there were
  apply(full, session_);
  ASSERT_EQ(session_.panelCount(), kMaxPanels);
  for (size_t i = 0; i < kMaxPanels; ++i) EXPECT_EQ(session_.panel(i).id, full.panelIds[i]);
}

TEST_F(EditHistoryTest, CornersOnAStraightLineComeBack) {
  const TransferCurves before = curves_;
  const double middle = 0.5 * (curves_.opacities[0].value + curves_.opacities[1].value);
  addOpacity(curves_, middle);  // which changes nothing that is to be seen
  const TransferCurves added = curves_;
  ASSERT_EQ(functionOf(added).at(middle), functionOf(before).at(middle));
  follow();
  EXPECT_EQ(history_.undoes(), "transfer function");
  removeOpacity(curves_, 1);
  follow();
  undo();
  EXPECT_EQ(curves_, added);
  undo();
  EXPECT_EQ(curves_, before);
}

TEST_F(EditHistoryTest, WhatNoHandHasSetIsNoStep) {
  LiveSettings knobs = session_.knobs();
  knobs.isFrozen = true;
  session_.setKnobs(knobs);
  session_.setHidden(1, true);
  turn(session_, 10.0);
  follow();
  EXPECT_EQ(history_.undoes(), "");
  setSide(128);
  follow();
  undo();
  EXPECT_TRUE(session_.knobs().isFrozen) << "as it is, not as it was";
  EXPECT_TRUE(session_.panel(1).isHidden);
}

TEST_F(EditHistoryTest, AnotherSceneBeginsAnew) {
  setSide(128);
  follow();
  ASSERT_TRUE(open("shells"));
  follow();
  EXPECT_EQ(history_.undoes(), "");
  EXPECT_FALSE(history_.undo());
}

TEST_F(EditHistoryTest, KeepsSoManySteps) {
  for (size_t i = 0; i < 2 * EditHistory::kMost; ++i) {
    setSide(128 + static_cast<uint32_t>(i % 2));
    follow();
  }
  size_t steps = 0;
  while (history_.undo()) ++steps;
  EXPECT_EQ(steps, EditHistory::kMost);
}

TEST_F(EditHistoryTest, EveryKnobHasANameInIt) {
  const auto stateWith = [&](const auto& change) {
    EditState state{session_.knobs(), {session_.panel(0), session_.panel(1)}, curves_};
    change(state);
    return state;
  };
  const EditState now = stateWith([](EditState&) {});
  EXPECT_EQ(changeBetween(now, now), "");
  EXPECT_EQ(changeBetween(now, stateWith([](EditState& state) { state.knobs.march.sample.heuristic = Heuristic::entrance; })), "Heuristic");
  EXPECT_EQ(changeBetween(now, stateWith([](EditState& state) { state.knobs.screenPixels = 3; })), "pixel size");
  EXPECT_EQ(changeBetween(now, stateWith([](EditState& state) { state.knobs.marks.uncovered = 1; })), "marks");
  EXPECT_EQ(changeBetween(now, stateWith([](EditState& state) { state.knobs.budgetMs = 3.0; })), "budget");
  EXPECT_EQ(changeBetween(now, stateWith([](EditState& state) { state.knobs.takesShortcuts = !state.knobs.takesShortcuts; })), "Shortcuts");
  EXPECT_EQ(changeBetween(now, stateWith([](EditState& state) { state.panels[0].contentRange = 2.0f; })), "range of the content of panel 1");
  EXPECT_EQ(changeBetween(now, stateWith([](EditState& state) { state.panels[0].isAutomatic = true; })), "technique of panel 1");
}

}  // namespace
}  // namespace warpscope
