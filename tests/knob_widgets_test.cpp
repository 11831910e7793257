// The column of knobs, drawn by Dear ImGui without a window and read as text: every knob's row has its widget, and turning one reaches the session.
// Mirrors app/ui/knob_parts.h and the part of app/ui/parts.h that is the column.
#include <imgui.h>

#include "app/ui/controls.h"
#include "app/ui/knob_parts.h"
#include "app/ui/parts.h"
#include "render/warp/points_warp.h"
#include "tests/extra_technique.h"
#include "tests/scripted_window.h"
#include "tests/session_fixture.h"

namespace warpscope::ui {
namespace {

std::string& clipboard() {
  static std::string text;
  return text;
}

/// A context of Dear ImGui whose frames go nowhere.
class Paper {
 public:
  Paper() : context_(ImGui::CreateContext()) {
    ImGuiIO& io = ImGui::GetIO();
    io.IniFilename = nullptr;
    io.DisplaySize = {1280.0f, 800.0f};
    io.DeltaTime = 1.0f / 60.0f;
    io.SetClipboardTextFn = [](void*, const char* text) { clipboard() = text; };
    unsigned char* pixels = nullptr;
    int width = 0, height = 0;
    io.Fonts->GetTexDataAsRGBA32(&pixels, &width, &height);
    look_.gl = &gl_;
    look_.hover = &hover_;
    look_.remembered = &remembered_;
    look_.fonts.body = look_.fonts.small = io.Fonts->Fonts[0];
  }
  ~Paper() { ImGui::DestroyContext(context_); }

  const Look& look() const { return look_; }

  /// One frame; all text that `draw` writes.
  template <class Draw>
  std::string textOf(const Draw& draw) {
    ImGui::NewFrame();
    ImGui::SetNextWindowSize({300.0f, 780.0f});
    ImGui::Begin("column");
    ImGui::LogToClipboard(0);  // folded up stays folded up
    draw();
    ImGui::LogFinish();
    ImGui::End();
    ImGui::Render();
    return clipboard();
  }

 private:
  ImGuiContext* const context_;
  const WindowGl gl_ = noGl();
  Hover hover_;
  Remembered remembered_;
  Look look_;
};

TEST(KnobWidget, EveryKindShowsItsLabelAndItsValue) {
  const Knob number{.key = "n", .label = "Number", .noun = "n", .help = "h", .unit = " %", .range = {0.0, 9.0}, .track = {0.0, 9.0}};
  const Knob whole{.key = "w", .label = "Whole", .noun = "w", .help = "h", .unit = " px", .type = KnobType::whole, .range = {1.0, 9.0}, .track = {1.0, 9.0}};
  static constexpr KnobChoice kChoices[] = {{"one", "1"}, {"other", "2"}};
  const Knob choice{.key = "c", .label = "Choice", .noun = "c", .help = "h", .type = KnobType::choice, .choices = kChoices};
  const Knob silent{.key = "s", .noun = "s", .help = "h", .range = {0.0, 9.0}};
  Paper paper;
  const std::string text = paper.textOf([&] {
    double value = 1.5;
    EXPECT_FALSE(knobWidget(number, value, paper.look()));
    value = 7.0;
    EXPECT_FALSE(knobWidget(whole, value, paper.look()));
    value = 1.0;
    EXPECT_FALSE(knobWidget(choice, value, paper.look()));
    EXPECT_FALSE(knobWidget(silent, value, paper.look()));
  });
  for (const char* words : {"Number", "1.50 %", "Whole", "7 px", "Choice", "other"}) EXPECT_THAT(text, testing::HasSubstr(words));
}

class Column : public SessionTest {
 protected:
  std::string text() {
    Paper paper;
    Controls controls;
    const SceneOpener none = [](const SceneOrigin& origin) { return LoadJob{origin.spec, {}}; };
    return paper.textOf([&] { controls.draw(session_, none, {}, EditHistory{}, paper.look()); });
  }
};

TEST_F(Column, HasAWidgetForEveryKnobThatHasALabel) {
  ASSERT_TRUE(open("block"));
  const WarpRegistration fog(extraTechnique());
  const std::string shown = text();
  for (const MarchKnob& row : marchKnobs())
    if (!row.knob->label.empty() && row.matters(session_.knobs().march)) EXPECT_THAT(shown, testing::HasSubstr(std::string(row.knob->label)));
  for (const Knob* knob : warpKnobs())
    if (!knob->isOfPanel) EXPECT_THAT(shown, testing::HasSubstr(std::string(knob->label)));
  EXPECT_THAT(shown, testing::HasSubstr(std::string(kShortcutsKnob.label)));
  for (const char* words : {"Fog's tint", "none", "0.25"}) EXPECT_THAT(shown, testing::HasSubstr(words));
}

TEST_F(Column, LeavesOutWhatDoesNotMatter) {
  ASSERT_TRUE(open("block"));
  EXPECT_THAT(text(), testing::Not(testing::HasSubstr("Threshold")));
  auto knobs = session_.knobs();
  knobs.march.sample.heuristic = Heuristic::threshold;
  session_.setKnobs(knobs);
  EXPECT_THAT(text(), testing::HasSubstr("Threshold"));
}

TEST_F(Column, SaysOfEveryStageWhetherItIsInAndWhy) {
  ASSERT_TRUE(open("block"));
  ASSERT_TRUE(pumpUntil([&] { return session_.plan().isKnown(); }));
  EXPECT_THAT(text(), testing::Not(testing::HasSubstr("early-end")));  // folded up
  session_.setShowsPlan(true);
  const std::string before = text();
  EXPECT_THAT(before, testing::HasSubstr("What each costs is measured when all rests."));
  for (const StageDescriptor& stage : kStages) {
    const PlannedStage& planned = (*session_.plan().plan())[stage.stage];
    EXPECT_THAT(before, testing::HasSubstr(std::string(stage.name)));
    EXPECT_THAT(before, testing::HasSubstr((planned.isIn ? "in: " : "out: ") + planned.reason.substr(0, 12)));
  }
  EXPECT_TRUE(session_.showsPlan());
  ASSERT_TRUE(pumpUntil([&] { return session_.plan().areCurrent(); }));
  EXPECT_THAT(text(), testing::HasSubstr("by each stage so much of it:"));
}

}  // namespace
}  // namespace warpscope::ui
