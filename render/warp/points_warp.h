// The frame's samples as OpenGL points of a fixed size in pixels, depth-tested.
// Zellmann, Aumueller, Lang 2012: vertex buffer, GL_POINTS.
#pragma once

#include "render/warp/warp.h"

namespace warpscope {

/// Edge of a point, pixels.
extern const Knob kPointSizeKnob;

extern const WarpDescriptor kPointsWarp;

}  // namespace warpscope
