// Steps that grow, and effects that go.
// See coarsening.h.
#include "app/frames/coarsening.h"

#include <algorithm>
#include <array>
#include <cstdio>

#include "render/march/march_knobs.h"

namespace warpscope {
namespace {

std::string shortText(const Knob& knob, double value) {
  if (knob.type != KnobType::number) return textOf(knob, value);
  char text[32];
  std::snprintf(text, sizeof text, "%.2g", value);
  return text;
}

/// Groups of effects, the first to go first: those without which matter still looks as it did, then what it looks like. Of all that can be seen a
/// picture loses most by the last.
constexpr std::array<void (*)(Effects&), 2> kDearEffects{
    [](Effects& effects) {
      effects.shadows.strength = effects.shadows.occlusion = 0.0f;
      effects.preIntegration = false;
    },
    [](Effects& effects) { effects.shading.strength = 0.0f; },
};

/// Calls `f(settings, leftOut)` for `asked` and for it without one group more after another, as long as that returns true.
template <class F>
void forEachLeftOut(const MarchSettings& asked, F&& f) {
  MarchSettings settings = asked;
  int leftOut = 0;
  if (!f(settings, leftOut)) return;
  for (const auto leave : kDearEffects) {
    const Effects before = settings.render.effects;
    leave(settings.render.effects);
    if (settings.render.effects != before && !f(settings, ++leftOut)) return;
  }
}

}  // namespace

int mostLeftOut(const MarchSettings& asked) {
  int most = 0;
  forEachLeftOut(asked, [&](const MarchSettings&, int leftOut) {
    most = leftOut;
    return true;
  });
  return most;
}

MarchSettings coarsened(const MarchSettings& asked, const Coarsening& coarsening) {
  MarchSettings settings;
  forEachLeftOut(asked, [&](const MarchSettings& left, int leftOut) {
    settings = left;
    return leftOut < coarsening.leftOut;
  });
  if (!(coarsening.factor > 1.0)) return settings;
  const double step = std::min(static_cast<double>(asked.render.step) * std::min(coarsening.factor, kMostCoarsening), kStepRange.highest);
  settings.render.step = std::max(asked.render.step, static_cast<float>(step));
  return settings;
}

std::optional<Coarsening> coarseningOf(const MarchSettings& asked, const MarchSettings& marched) {
  const double factor = static_cast<double>(marched.render.step) / static_cast<double>(asked.render.step);
  // A float's rounding may have brought the greatest step a little above.
  if (!(factor >= 1.0) || marched.render.step > coarsened(asked, {kMostCoarsening}).render.step) return std::nullopt;
  std::optional<Coarsening> found;
  forEachLeftOut(asked, [&](MarchSettings expected, int leftOut) {
    expected.render.step = marched.render.step;  // which a factor of two steps does not say to the last bit
    if (expected == marched) found = {factor, leftOut};
    return !found;
  });
  return found;
}

bool isCoarsened(const MarchSettings& asked, const MarchSettings& marched) {
  const std::optional<Coarsening> coarsening = coarseningOf(asked, marched);
  return coarsening && *coarsening != Coarsening{};
}

std::string coarseningText(const MarchSettings& asked, const MarchSettings& marched) {
  std::string text, without;
  for (const MarchKnob& row : marchKnobs()) {
    const double before = row.get(asked), after = row.get(marched);
    if (before == after) continue;
    if (row.knob->owner == KnobOwner::effect && after == 0.0) {
      without += (without.empty() ? "without " : ", ") + std::string(row.knob->option.substr(2));  // its name, behind two hyphens
      continue;
    }
    text += (text.empty() ? "" : ", ") + std::string(row.knob->noun) + " " + shortText(*row.knob, after) + " instead of " + shortText(*row.knob, before);
  }
  return text.empty() || without.empty() ? text + without : text + ", " + without;
}

}  // namespace warpscope
