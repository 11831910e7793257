// The nearest few spheres along each ray, their colours over each other: what is translucent stays so. Several samples of a ray are as many
// spheres: with fewer hits than those the farthest are missing.
// Spheres over an LBVH as Zellmann 2020, hits as Gribble, Naveros, Kerzner 2014; see multihit/.
#pragma once

#include "render/warp/warp.h"

namespace warpscope {

/// Samples blended along a ray, 1..kMaxHits.
extern const Knob kHitsKnob;

extern const WarpDescriptor kMultihitWarp;

}  // namespace warpscope
