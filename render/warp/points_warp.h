// The frame's samples as OpenGL points of a fixed size in pixels, depth-tested: of several that share a pixel, of one ray too, the nearest is seen.
// Zellmann, Aumueller, Lang 2012: vertex buffer, GL_POINTS.
#pragma once

#include "render/warp/warp.h"

namespace warpscope {

/// Edge of a point, pixels.
extern const Knob kPointSizeKnob;

extern const WarpDescriptor kPointsWarp;

}  // namespace warpscope
