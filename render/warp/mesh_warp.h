// The frame's depth image as a surface of triangles, cut where depth jumps: what streaming to headsets does.
// Mark, McMillan, Bishop 1997 ("Post-Rendering 3D Warping"), 3: neighbours are joined, unless they do not belong together.
#pragma once

#include "render/warp/warp.h"

namespace warpscope {

/// By how much depths of neighbours may differ that are joined, as a share of the nearer one.
extern const Knob kMeshCutKnob;

extern const WarpDescriptor kMeshWarp;

}  // namespace warpscope
