// The nearest few spheres along each ray, their colours over each other: what is translucent stays so.
// Spheres over an LBVH as Zellmann 2020, hits as Gribble, Naveros, Kerzner 2014; see multihit/.
#pragma once

#include "render/warp/warp.h"

namespace warpscope {

std::unique_ptr<Warp> makeMultihitWarp(const WarpResources& resources);

}  // namespace warpscope
