// The nearest few surfaces along each ray, their colours over each other: what is translucent stays so. Neighbouring samples of one surface count once, several samples of a ray as
// many times: with fewer hits than those the farthest are missing. In the frame's own view it is the frame's own picture.
// Spheres over an LBVH as Zellmann 2020, hits as Gribble, Naveros, Kerzner 2014; what is one surface, and where that is from: multihit/.
#pragma once

#include "render/warp/warp.h"

namespace warpscope {

/// Surfaces blended along a ray, 1..kMaxHits.
extern const Knob kHitsKnob;

extern const WarpDescriptor kMultihitWarp;

}  // namespace warpscope
