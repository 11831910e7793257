// Segments of rays, met again by the rays of another camera: what lies in front, between and behind is where it was.
// After the volumetric depth images of Frey, Sadlo, Ertl 2013; see segments/segment_walk.h and nearest_walk.h.
#pragma once

#include "render/warp/segments/between.h"
#include "render/warp/warp.h"

namespace warpscope {

extern const Knob kBetweenKnob;

class ProxyFill;

/// What lies between the rays of a frame with segments in a picture with those knobs: nothing is refined that the frame's copy does not fill, or does not show as the volume is.
Between betweenOf(const SampleFrame& frame, const KnobValues& knobs, ProxyFill& fill);

extern const WarpDescriptor kSegmentsWarp;

}  // namespace warpscope
