// Plots as pictures, for where SVG is not taken.
// Shapes by how much of a pixel they cover (signed distances), blended in sRGB codes as screens do; text by text.h.
#pragma once

#include "app/picture/plot.h"
#include "render/core/color.h"
#include "render/core/image.h"

namespace warpscope {

/// On white, opaque. `scale`: pixels for each unit of the SVG, 0.5 to 8; 1 is 760 by 420 pixels for a legend of short names.
Image<Rgba8> pictureOf(const Plot& plot, float scale);

}  // namespace warpscope
