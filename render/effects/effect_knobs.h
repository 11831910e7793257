// The knobs of effects, gathered: each effect brings its own.
// march_knobs.h lists them with the march's.
#pragma once

#include "render/march/march_knobs.h"

namespace warpscope {

std::span<const MarchKnob> effectKnobs();
std::span<const MarchText> effectTexts();

/// Of rows that matter whatever the others are.
constexpr bool always(const MarchSettings&) { return true; }

extern const Knob kShadingKnob, kAmbientKnob, kDiffuseKnob, kSpecularKnob, kExponentKnob;
extern const Knob kModeKnob;
extern const Knob kSlabKnob, kSlabDepthKnob;

}  // namespace warpscope
