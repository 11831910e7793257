// Errors as colours: black where there is none, through violet and orange to pale yellow at the largest.
// Lightness rises evenly along the ramp, so that more is always brighter, also in grey.
#pragma once

#include "render/core/color.h"
#include "render/core/image.h"

namespace warpscope {

/// `value` from 0 to 1; clamps; NaN is 0.
Rgba8 heatColor(float value);

/// For FLIP: the ramp's upper end stands for 0.5, more than what warps usually differ by.
inline constexpr float kHeatGain = 2.0f;

/// `map` times `gain`, as colours.
Image<Rgba8> heatMap(const Image<float>& map, float gain = 1.0f);

}  // namespace warpscope
