// What columns of knobs are made of: headings, labels, choices, sliders.
// A label stands on the left, its knob fills the rest of the line.
#pragma once

#include <imgui.h>

#include <cmath>
#include <string>

#include "app/ui/parts.h"
#include "render/base/knob.h"

namespace warpscope::ui {

inline constexpr float kLabelWidth = 92.0f;  // at scale 1

/// A heading that folds what is below it up, which is remembered; whether that is to be drawn.
inline bool section(const char* text, const Look& look) {
  ImGui::Dummy({0.0f, 0.0f});
  ImGui::PushFont(look.fonts.small);
  ImGui::PushStyleColor(ImGuiCol_Text, palette().accent);
  ImGui::PushStyleColor(ImGuiCol_Header, {0.0f, 0.0f, 0.0f, 0.0f});
  ImGui::PushStyleVar(ImGuiStyleVar_FramePadding, {0.0f, look.px(1.0f)});
  const bool wasOpen = !look.remembered->folded.contains(text);
  ImGui::SetNextItemOpen(wasOpen);
  const bool isOpen = ImGui::TreeNodeEx(text, ImGuiTreeNodeFlags_NoTreePushOnOpen | ImGuiTreeNodeFlags_SpanAvailWidth);
  if (isOpen != wasOpen) look.remembered->setFolded(text, !isOpen);
  ImGui::PopStyleVar();
  ImGui::PopStyleColor(2);
  ImGui::PopFont();
  return isOpen;
}

/// A label on the left, which explains itself where there is an explanation; what comes next fills the rest of the line. `width` at scale 1.
inline void label(const char* text, const Look& look, const std::string& explanation = "", float width = kLabelWidth) {
  const float left = ImGui::GetCursorPosX();
  ImGui::AlignTextToFramePadding();
  ImGui::TextUnformatted(text);
  if (!explanation.empty()) tooltip(explanation, look);
  ImGui::SameLine(left + look.px(width));
  ImGui::SetNextItemWidth(-1.0f);
}

/// The widget that a knob's row describes, with its label and what it does. True if `value` was changed. A knob without a label has none.
bool knobWidget(const Knob& knob, double& value, const Look& look);

/// The widget alone, of the width that was set for the next item.
bool bareKnobWidget(const Knob& knob, double& value, const Look& look);

/// As knobWidget, for what a row of a structure turns.
template <class Settings>
void knobWidget(const KnobRow<Settings>& row, Settings& settings, const Look& look) {
  double value = row.get(settings);
  if (knobWidget(*row.knob, value, look)) row.set(settings, value);
}

/// What a slider goes through, and how its value is written.
struct Track {
  float lowest, highest;
  const char* format;
  bool isLogarithmic = false;
};

/// A slider of the width that was set for the next item.
inline void bareSlider(const char* id, float& value, const Track& track, const char* explanation, const Look& look) {
  ImGui::PushID(id);
  float edited = value;
  const ImGuiSliderFlags flags = ImGuiSliderFlags_AlwaysClamp | (track.isLogarithmic ? ImGuiSliderFlags_Logarithmic : 0);
  if (ImGui::SliderFloat("##slider", &edited, track.lowest, track.highest, track.format, flags) && std::isfinite(edited)) value = edited;
  tooltip(explanation, look);
  ImGui::PopID();
}

inline void slider(const char* text, float& value, const Track& track, const char* explanation, const Look& look) {
  label(text, look, explanation);
  bareSlider(text, value, track, explanation, look);
}

/// After label(): what comes next fills half of what is left of the line, and what follows it the rest.
inline void beginHalves() { ImGui::SetNextItemWidth(0.5f * (ImGui::GetContentRegionAvail().x - ImGui::GetStyle().ItemInnerSpacing.x)); }
inline void nextHalf() {
  ImGui::SameLine(0.0f, ImGui::GetStyle().ItemInnerSpacing.x);
  ImGui::SetNextItemWidth(-1.0f);
}

}  // namespace warpscope::ui
