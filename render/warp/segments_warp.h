// Segments of rays, met again by the rays of another camera: what lies in front, between and behind is where it was.
// After the volumetric depth images of Frey, Sadlo, Ertl 2013; see segments/segment_walk.h.
#pragma once

#include "render/warp/warp.h"

namespace warpscope {

extern const WarpDescriptor kSegmentsWarp;

}  // namespace warpscope
