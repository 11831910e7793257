// Steps that grow.
// See coarsening.h.
#include "app/frames/coarsening.h"

#include <algorithm>
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

}  // namespace

MarchSettings coarsened(const MarchSettings& asked, double factor) {
  MarchSettings settings = asked;
  if (!(factor > 1.0)) return settings;
  const double step = std::min(static_cast<double>(asked.render.step) * std::min(factor, kMostCoarsening), kStepRange.highest);
  settings.render.step = std::max(asked.render.step, static_cast<float>(step));
  return settings;
}

double coarseningOf(const MarchSettings& asked, const MarchSettings& marched) {
  const double factor = static_cast<double>(marched.render.step) / static_cast<double>(asked.render.step);
  // A float's rounding may have brought the greatest step a little above.
  if (!(factor > 1.0) || marched.render.step > coarsened(asked, kMostCoarsening).render.step) return 1.0;
  MarchSettings expected = coarsened(asked, factor);
  expected.render.step = marched.render.step;  // which a factor of two steps does not say to the last bit
  return expected == marched ? factor : 1.0;
}

bool isCoarsened(const MarchSettings& asked, const MarchSettings& marched) { return coarseningOf(asked, marched) > 1.0; }

std::string coarseningText(const MarchSettings& asked, const MarchSettings& marched) {
  std::string text;
  for (const MarchKnob& row : marchKnobs()) {
    const double before = row.get(asked), after = row.get(marched);
    if (before == after) continue;
    text += (text.empty() ? "" : ", ") + std::string(row.knob->noun) + " " + shortText(*row.knob, after) + " instead of " + shortText(*row.knob, before);
  }
  return text;
}

}  // namespace warpscope
