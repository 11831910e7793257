// What stands above a panel's picture: its title, and what is chosen for it.
// See panel_header.h.
#include "app/ui/panel_header.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "app/picture/content.h"
#include "app/ui/knob_parts.h"

namespace warpscope::ui {
namespace {

constexpr float kTitlePx = 17.0f;  // at scale 1
constexpr float kTechniquePx = 134.0f, kContentPx = 92.0f, kKnobPx = 96.0f, kLeastKnobPx = 68.0f;  // at scale 1

/// Widths of the two lists: what their entries on show need, and not less than usual, as long as there is room; else each its part of it.
struct ChoiceWidths {
  float technique, content;
};

ChoiceWidths widthsOf(const std::string& technique, std::string_view content, bool hasMore, const Look& look) {
  const ImGuiStyle& style = ImGui::GetStyle();
  const auto needed = [&](std::string_view text) { return ImGui::CalcTextSize(text.data(), text.data() + text.size()).x + ImGui::GetFrameHeight() + 2.0f * style.FramePadding.x; };
  const float room = ImGui::GetContentRegionAvail().x - style.ItemSpacing.x - (hasMore ? ImGui::GetFrameHeight() + style.ItemSpacing.x : 0.0f);
  const ChoiceWidths least{needed(technique), needed(content)}, usual{std::max(look.px(kTechniquePx), least.technique), std::max(look.px(kContentPx), least.content)};
  if (usual.technique + usual.content <= room) return usual;
  const float spare = std::max(0.0f, room - least.technique - least.content), share = std::min(1.0f, room / (least.technique + least.content));
  return {share * least.technique + 0.5f * spare, share * least.content + 0.5f * spare};
}

/// The technique's, of which each panel has its own.
std::vector<const Knob*> ownKnobs(const WarpDescriptor& technique) {
  std::vector<const Knob*> own;
  for (const Knob* knob : technique.knobs)
    if (knob->isOfPanel) own.push_back(knob);
  return own;
}

std::string techniqueOnShow(const Panel& panel) { return (panel.isAutomatic ? "Auto: " : "") + std::string(panel.technique->label); }

void drawTechniqueChoice(Session& session, size_t index, float width, const Look& look) {
  const WarpDescriptor& technique = *session.panel(index).technique;
  ImGui::SetNextItemWidth(width);
  const Panel& panel = session.panel(index);
  const bool isOpen = ImGui::BeginCombo("##technique", techniqueOnShow(panel).c_str());
  if (!isOpen) {
    const std::string explanation = panel.isAutomatic && !panel.choiceText.empty() ? panel.choiceText : std::string(technique.summary);
    tooltip(explanation + ".\nKeys 1 to " + std::to_string(std::min<size_t>(9, warpRegistry().size())) + " choose a technique for the panel under the pointer, 0 lets it choose by itself.", look);
  }
  if (!isOpen) return;
  if (ImGui::Selectable("0  Auto", panel.isAutomatic)) session.setAutomatic(index);
  tooltip("What has the least error at this angle within the budget: of a sweep (view --front, or dropped onto the window), or of what was on show so far", look);
  for (const WarpDescriptor& choice : warpRegistry()) {
    const std::string label = std::to_string(&choice - warpRegistry().data() + 1) + "  " + std::string(choice.label);
    if (ImGui::Selectable(label.c_str(), !panel.isAutomatic && &choice == &technique)) session.setTechnique(index, choice);
    tooltip(std::string(choice.summary), look);
  }
  ImGui::EndCombo();
}

/// What the panel shows: its picture, or what is wrong with it, or what its pixels are made of.
void drawContentChoice(Session& session, size_t index, float width, const Look& look) {
  const Panel& panel = session.panel(index);
  const ContentDescriptor& shown = describe(panel.content);
  ImGui::SameLine();
  ImGui::SetNextItemWidth(width);
  const bool isOpen = ImGui::BeginCombo("##content", std::string(shown.label).c_str());
  if (!isOpen) {
    tooltip(std::string(shown.help) + (shown.unit.empty() ? "." : ". The list's last entry is what the end of its colours stands for.") + "\nKey H goes back and forth between the picture and what was shown in its place last.", look);
    return;
  }
  for (const ContentDescriptor& choice : pictureContents()) {
    if (ImGui::Selectable(std::string(choice.label).c_str(), choice.value == panel.content)) session.setContent(index, choice.value);
    tooltip(std::string(choice.help), look);
  }
  if (!shown.unit.empty()) {
    ImGui::Separator();
    float range = panel.contentRange.value_or(panel.hasContentOnShow() ? panel.shownContent.high : shown.usualRange.value_or(1.0f));
    const float before = range, most = shown.unit == "1" ? 1.0f : std::max(1000.0f, 2.0f * range);
    bareSlider("range", range, {1e-3f, most, "up to %.3g", true}, "What the brightest colour stands for. Choosing the content again takes the usual range.", look);
    if (range != before) session.setContent(index, panel.content, range);
  }
  ImGui::EndCombo();
}

/// What the technique has for each panel by itself: in the line, or where that has too little room, behind a button.
void drawPanelKnobs(Session& session, size_t index, const Look& look) {
  KnobValues knobs = session.panel(index).knobs;
  bool isChanged = false;
  const auto turn = [&](const Knob& knob, auto&& widget) {
    double value = knobs[knob];
    if (!widget(knob, value, look)) return;
    knobs.set(knob, value);
    isChanged = true;
  };
  const std::vector<const Knob*> own = ownKnobs(*session.panel(index).technique);
  if (own.empty()) return;
  ImGui::SameLine();
  const float gap = ImGui::GetStyle().ItemSpacing.x;
  const auto count = static_cast<float>(own.size());
  const float room = (ImGui::GetContentRegionAvail().x - (count - 1.0f) * gap) / count;
  if (room >= look.px(kLeastKnobPx)) {
    for (const Knob* knob : own) {
      if (knob != own.front()) ImGui::SameLine();
      ImGui::SetNextItemWidth(std::min(room, look.px(kKnobPx)));
      turn(*knob, bareKnobWidget);
    }
  } else {
    ImGui::SetNextItemWidth(ImGui::GetFrameHeight());
    const bool isOpen = ImGui::BeginCombo("##knobs", "", ImGuiComboFlags_NoPreview);
    if (!isOpen) tooltip("The technique's knobs for this panel.", look);
    if (isOpen) {
      ImGui::Dummy({look.px(kLabelWidth + kKnobPx), 0.0f});
      for (const Knob* knob : own) {
        label(std::string(knob->label.empty() ? knob->noun : knob->label).c_str(), look);
        turn(*knob, bareKnobWidget);
      }
      ImGui::EndCombo();
    }
  }
  if (isChanged) session.setPanelKnobs(index, knobs);
}

/// For a panel that chooses by itself: how long a picture may take.
void drawBudget(Session& session, const Look& look) {
  ImGui::SameLine();
  ImGui::SetNextItemWidth(std::min(look.px(110.0f), std::max(look.px(30.0f), ImGui::GetContentRegionAvail().x)));
  LiveSettings knobs = session.knobs();
  float budgetMs = static_cast<float>(knobs.budgetMs);
  bareSlider("budget", budgetMs, {1.0f, 1000.0f, "%.0f ms", true}, "Budget: milliseconds that a new frame's picture may take (decoding, building, drawing).", look);
  if (budgetMs == static_cast<float>(knobs.budgetMs)) return;
  knobs.budgetMs = budgetMs;
  session.setKnobs(knobs);
}

/// What is seen, in a few words.
std::string titleOf(const Session& session, size_t index) {
  const Panel& panel = session.panel(index);
  std::string title(panel.technique->label);
  if (panel.content != PictureContent::picture) title += ": " + std::string(describe(panel.content).label);
  if (session.hasOwnCamera(index)) title += ", own camera";
  if (session.playback().isOpen())
    title += ", recorded";
  else if (session.knobs().isFrozen && panel.technique->usesFrame)
    title += ", frozen";
  return title;
}

enum class Icon { close, maximise, camera };

void drawIcon(Icon icon, const ImVec2& center, float radius, ImU32 color, float thickness) {
  ImDrawList* list = ImGui::GetWindowDrawList();
  const ImVec2 a{center.x - radius, center.y - radius}, b{center.x + radius, center.y + radius};
  switch (icon) {
    case Icon::close:
      list->AddLine(a, b, color, thickness);
      list->AddLine({a.x, b.y}, {b.x, a.y}, color, thickness);
      return;
    case Icon::maximise: list->AddRect(a, b, color, 0.0f, 0, thickness); return;
    case Icon::camera:  // a box with a lens at its side
      list->AddRect({a.x, center.y - 0.7f * radius}, {center.x + 0.4f * radius, center.y + 0.7f * radius}, color, 0.0f, 0, thickness);
      list->AddTriangleFilled({center.x + 0.4f * radius, center.y}, {b.x, center.y - 0.6f * radius}, {b.x, center.y + 0.6f * radius}, color);
      return;
  }
}

/// A square that is pressed; as high as the title.
bool iconButton(Icon icon, const char* id, bool isOn, const Action action, const Look& look) {
  const float side = look.px(kTitlePx);
  const ImVec2 at = ImGui::GetCursorScreenPos();
  const bool isPressed = ImGui::InvisibleButton(id, {side, side});
  const ImVec4 color = isOn ? palette().accent : ImGui::IsItemHovered() ? ImGui::GetStyleColorVec4(ImGuiCol_Text) : palette().faintText;
  drawIcon(icon, {at.x + 0.5f * side, at.y + 0.5f * side}, look.px(4.0f), ImGui::GetColorU32(color), std::max(1.0f, look.px(1.2f)));
  tooltip(action, look);
  return isPressed;
}

/// Drags the panel to another's place; asks for what its buttons say.
std::optional<Action> drawTitle(Session& session, size_t index, bool isAlone, const Look& look) {
  std::optional<Action> asked;
  const bool canClose = session.panelCount() > 1;
  const float side = look.px(kTitlePx), buttons = side * (canClose ? 3.0f : 2.0f);
  const float width = std::max(side, ImGui::GetContentRegionAvail().x - buttons);
  const std::string title = titleOf(session, index);
  const ImVec2 at = ImGui::GetCursorScreenPos();
  ImGui::InvisibleButton("title", {width, side});
  if (ImGui::IsItemHovered() && look.isDoubleClicked) asked = Action::maximise;
  if (session.panelCount() > 1) tooltip("Drag this to another panel's place; a double click shows this panel alone.", look);
  if (session.panelCount() > 1 && ImGui::BeginDragDropSource(ImGuiDragDropFlags_SourceNoPreviewTooltip)) {
    const uint64_t id = session.panel(index).id;
    ImGui::SetDragDropPayload(kPanelPayload, &id, sizeof(id));
    ImGui::EndDragDropSource();
  }
  ImDrawList* list = ImGui::GetWindowDrawList();
  ImGui::PushFont(look.fonts.small);
  list->PushClipRect(at, {at.x + width, at.y + side}, true);
  list->AddText({at.x, at.y + 0.5f * (side - ImGui::GetTextLineHeight())}, ImGui::GetColorU32(session.knobs().isFrozen ? palette().noticeText : palette().dimText), title.c_str());
  list->PopClipRect();
  ImGui::PopFont();
  ImGui::SameLine(0.0f, 0.0f);
  if (iconButton(Icon::camera, "camera", session.hasOwnCamera(index), Action::ownCamera, look)) asked = Action::ownCamera;
  ImGui::SameLine(0.0f, 0.0f);
  if (iconButton(Icon::maximise, "maximise", isAlone, Action::maximise, look)) asked = Action::maximise;
  if (!canClose) return asked;
  ImGui::SameLine(0.0f, 0.0f);
  if (iconButton(Icon::close, "close", false, Action::closePanel, look)) asked = Action::closePanel;
  return asked;
}

}  // namespace

float panelHeaderHeight(const Look& look) { return look.px(kTitlePx) + ImGui::GetFrameHeight() + 2.0f * ImGui::GetStyle().ItemSpacing.y; }

std::optional<Action> drawPanelHeader(Session& session, size_t index, bool isAlone, const Look& look) {
  const std::optional<Action> asked = drawTitle(session, index, isAlone, look);
  const Panel& panel = session.panel(index);
  const bool hasMore = panel.isAutomatic || !ownKnobs(*panel.technique).empty();
  const ChoiceWidths widths = widthsOf(techniqueOnShow(panel), describe(panel.content).label, hasMore, look);
  drawTechniqueChoice(session, index, widths.technique, look);
  drawContentChoice(session, index, widths.content, look);
  drawPanelKnobs(session, index, look);
  if (session.panel(index).isAutomatic) drawBudget(session, look);
  return asked;
}

}  // namespace warpscope::ui
