// The knobs of effects, and lists that are typed: lights.
// See parts.h.
#include <algorithm>

#include "app/ui/knob_parts.h"
#include "app/ui/parts.h"
#include "render/base/error.h"
#include "render/march/march_knobs.h"

namespace warpscope::ui {

void EffectKnobs::draw(MarchSettings& settings, const Look& look) {
  if (!section("EFFECTS", look)) return;
  for (const MarchKnob& row : marchKnobs())
    if (row.knob->owner == KnobOwner::effect && row.matters(settings)) knobWidget(row, settings, look);
  for (const MarchText& text : marchTexts())
    if (text.matters(settings)) drawText(text, settings, look);
}

void EffectKnobs::drawText(const MarchText& text, MarchSettings& settings, const Look& look) {
  Typed& typed = typed_[&text];
  const std::string current = text.get(settings);
  if (typed.setting != current) typed.refusal.clear();  // set from elsewhere since: what was typed is of yesterday
  if (!typed.isActive && typed.refusal.empty()) {
    const size_t size = std::min(current.size(), typed.text.size() - 1);
    std::copy_n(current.begin(), size, typed.text.begin());
    typed.text[size] = '\0';
  }
  label(std::string(text.label).c_str(), look);
  ImGui::PushID(std::string(text.key).c_str());
  ImGui::InputText("##text", typed.text.data(), typed.text.size());
  typed.isActive = ImGui::IsItemActive();
  const bool isTyped = ImGui::IsItemDeactivatedAfterEdit();
  tooltip(std::string(text.help) + ": " + std::string(text.values) + ".", look);
  ImGui::PopID();
  if (isTyped) {
    typed.refusal.clear();
    try {
      text.set(settings, typed.text.data(), text.label);
    } catch (const UsageError& error) {
      typed.refusal = error.what();
      typed.setting = current;
    }
  }
  if (typed.refusal.empty()) return;
  ImGui::PushTextWrapPos(0.0f);
  ImGui::TextColored(palette().errorText, "%s", typed.refusal.c_str());
  ImGui::PopTextWrapPos();
}

}  // namespace warpscope::ui
