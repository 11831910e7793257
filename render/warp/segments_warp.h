// Segments of rays, met again by the rays of another camera: what lies in front, between and behind is where it was.
// After the volumetric depth images of Frey, Sadlo, Ertl 2013; see segments/segment_walk.h and nearest_walk.h.
#pragma once

#include "render/warp/warp.h"

namespace warpscope {

/// What lies between the rays of pixels.
enum class Between { nearest, linear };
extern const Knob kBetweenKnob;

extern const WarpDescriptor kSegmentsWarp;

}  // namespace warpscope
