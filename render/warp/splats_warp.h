// The picture of `spheres`, sample for sample, without a hierarchy: every sphere looks for its pixels instead of every pixel for its sphere.
// Ours; see splats/splat_tracer.h.
#pragma once

#include "render/warp/warp.h"

namespace warpscope {

extern const WarpDescriptor kSplatsWarp;

}  // namespace warpscope
