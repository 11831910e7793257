// Checks of the server's knobs.
// See march_settings.h.
#include "render/march/march_settings.h"

#include "render/base/error.h"
#include "render/march/march_knobs.h"

namespace warpscope {
namespace {

void validateOwned(KnobOwner owner, const MarchSettings& settings) {
  for (const MarchKnob& row : marchKnobs())
    if (row.knob->owner == owner) validate(*row.knob, row.get(settings), "the " + std::string(row.knob->noun));
}

}  // namespace

void validate(const RenderSettings& settings) {
  validateOwned(KnobOwner::rendering, {settings, {}});
  validateOwned(KnobOwner::effect, {settings, {}});
}

void validate(const SampleSettings& settings) {
  validateOwned(KnobOwner::sampling, {{}, settings});
}

void validate(const MarchSettings& settings) {
  validate(settings.render);
  validate(settings.sample);
  if (settings.render.arithmetic != Arithmetic::stable) throw UsageError("samples are found in stable arithmetic alone");
}

}  // namespace warpscope
