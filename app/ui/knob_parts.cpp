// Widgets from rows of knobs.
// See knob_parts.h.
#include "app/ui/knob_parts.h"

#include <algorithm>

namespace warpscope::ui {
namespace {

/// A unit in a format of printf.
std::string escaped(std::string_view text) {
  std::string escaped;
  for (const char c : text) escaped += c == '%' ? std::string("%%") : std::string(1, c);
  return escaped;
}

bool choiceWidget(const Knob& knob, double& value, const Look& look) {
  bool isChanged = false;
  const bool isOpen = ImGui::BeginCombo("##choice", textOf(knob, value).c_str());
  if (!isOpen) {
    tooltip(std::string(knob.help) + ".", look);
    return false;
  }
  for (size_t i = 0; i < knob.choices.size(); ++i) {
    const bool isChosen = static_cast<double>(i) == value;
    if (ImGui::Selectable(std::string(knob.choices[i].name).c_str(), isChosen) && !isChosen) {
      value = static_cast<double>(i);
      isChanged = true;
    }
    tooltip(std::string(knob.choices[i].summary), look);
  }
  ImGui::EndCombo();
  return isChanged;
}

bool sliderWidget(const Knob& knob, double& value) {
  const ImGuiSliderFlags flags = ImGuiSliderFlags_AlwaysClamp | (knob.scale == KnobScale::logarithmic ? ImGuiSliderFlags_Logarithmic : 0);
  const std::string unit = escaped(knob.unit);
  double edited = value;
  if (knob.type == KnobType::whole) {
    int whole = static_cast<int>(value);
    const bool isOne = whole == 1 && unit.size() > 3 && unit.ends_with('s');  // "1 frame", but "1 ms"
    ImGui::SliderInt("##slider", &whole, static_cast<int>(knob.track.lowest), static_cast<int>(knob.track.highest), ("%d" + (isOne ? unit.substr(0, unit.size() - 1) : unit)).c_str(),
                     flags);
    edited = whole;
  } else {
    float number = static_cast<float>(value);
    ImGui::SliderFloat("##slider", &number, static_cast<float>(knob.track.lowest), static_cast<float>(knob.track.highest),
                       ("%." + std::to_string(knob.decimals) + "f" + unit).c_str(), flags);
    edited = number;
  }
  if (edited == value || !std::isfinite(edited)) return false;
  value = std::clamp(edited, knob.range.lowest, knob.range.highest);
  return true;
}

}  // namespace

bool knobWidget(const Knob& knob, double& value, const Look& look) {
  if (knob.label.empty()) return false;
  const std::string text(knob.label);
  label(text.c_str(), look, std::string(knob.help) + ".");
  return bareKnobWidget(knob, value, look);
}

bool bareKnobWidget(const Knob& knob, double& value, const Look& look) {
  ImGui::PushID(std::string(knob.key).c_str());
  bool isChanged = false;
  switch (knob.type) {
    case KnobType::choice: isChanged = choiceWidget(knob, value, look); break;
    case KnobType::flag: {
      bool isSet = value != 0.0;
      isChanged = ImGui::Checkbox("##flag", &isSet);
      value = isSet ? 1.0 : 0.0;
      tooltip(std::string(knob.help) + ".", look);
      break;
    }
    case KnobType::number:
    case KnobType::whole:
      isChanged = sliderWidget(knob, value);
      if (ImGui::IsItemClicked(ImGuiMouseButton_Right) && value != knob.defaultValue) {
        value = knob.defaultValue;
        isChanged = true;
      }
      tooltip(std::string(knob.help) + ". A click with Ctrl types a value, the right button brings " + textOf(knob, knob.defaultValue) + " back.", look);
      break;
  }
  ImGui::PopID();
  return isChanged;
}

}  // namespace warpscope::ui
