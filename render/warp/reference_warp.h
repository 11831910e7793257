// The ground truth: the volume marched at the current camera.
// No warping: what every other technique is measured against (Zellmann 2020, figure 3).
#pragma once

#include "render/warp/warp.h"

namespace warpscope {

extern const WarpDescriptor kReferenceWarp;

}  // namespace warpscope
