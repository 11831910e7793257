// First hit of primary rays with one sphere per sample, the sample's colour, no shading.
// Zellmann 2020, over a linear BVH (Karras 2012) or, as a check and baseline, Embree.
#pragma once

#include "render/warp/warp.h"

namespace warpscope {

std::unique_ptr<Warp> makeSpheresWarp(const WarpResources& resources);

}  // namespace warpscope
