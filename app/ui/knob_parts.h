// What columns of knobs are made of: headings, labels, choices, sliders.
// A label stands on the left, its knob fills the rest of the line.
#pragma once

#include <imgui.h>

#include <cmath>
#include <string>

#include "app/ui/parts.h"

namespace warpscope::ui {

inline constexpr float kLabelWidth = 92.0f;  // at scale 1

inline void heading(const char* text, const Look& look) {
  ImGui::Dummy({0.0f, 0.0f});
  ImGui::PushFont(look.fonts.small);
  ImGui::TextColored(kAccent, "%s", text);
  ImGui::PopFont();
}

/// A label on the left; what comes next fills the rest of the line.
inline void label(const char* text, const Look& look) {
  const float left = ImGui::GetCursorPosX();
  ImGui::AlignTextToFramePadding();
  ImGui::TextUnformatted(text);
  ImGui::SameLine(left + look.px(kLabelWidth));
  ImGui::SetNextItemWidth(-1.0f);
}

/// A choice among a table of NamedValue.
template <class Table, class Value>
void choice(const char* text, const Table& table, Value& value, const char* explanation, const Look& look) {
  label(text, look);
  ImGui::PushID(text);
  const bool isOpen = ImGui::BeginCombo("##choice", std::string(nameOf(value)).c_str());
  if (!isOpen) tooltip(explanation, look);
  if (isOpen) {
    for (const auto& entry : table) {
      if (ImGui::Selectable(std::string(entry.name).c_str(), entry.value == value)) value = entry.value;
      tooltip(std::string(entry.summary), look);
    }
    ImGui::EndCombo();
  }
  ImGui::PopID();
}

inline void slider(const char* text, float& value, float lowest, float highest, const char* format, bool isLogarithmic,
                   const char* explanation, const Look& look) {
  label(text, look);
  ImGui::PushID(text);
  float edited = value;
  const ImGuiSliderFlags flags = ImGuiSliderFlags_AlwaysClamp | (isLogarithmic ? ImGuiSliderFlags_Logarithmic : 0);
  if (ImGui::SliderFloat("##slider", &edited, lowest, highest, format, flags) && std::isfinite(edited)) value = edited;
  tooltip(explanation, look);
  ImGui::PopID();
}

}  // namespace warpscope::ui
