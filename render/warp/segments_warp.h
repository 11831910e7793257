// Segments of rays, met again by the rays of another camera: what lies in front, between and behind is where it was.
// After the volumetric depth images of Frey, Sadlo, Ertl 2013; see segments/segment_walk.h and nearest_walk.h.
#pragma once

#include "render/warp/segments/between.h"
#include "render/warp/warp.h"

namespace warpscope {

extern const Knob kBetweenKnob;

/// Whether rays through a frame with segments go on through its copy of the volume where it knows nothing, in a picture with those knobs.
bool isFilledFromCopy(const SampleFrame& frame, const KnobValues& knobs);
/// What lies between its rays then, for `camera`: nothing is refined that the copy does not fill, or does not show as the volume is, and nothing in the frame's own view, where each ray is a pixel's.
Between betweenOf(const SampleFrame& frame, const Camera& camera, const KnobValues& knobs);

extern const WarpDescriptor kSegmentsWarp;

}  // namespace warpscope
