// The frame's own picture on a plane, seen by another camera: a homography, which knows no depth (asynchronous time warp; van Waveren 2016).
// See rotated_picture.h.
#pragma once

#include "render/warp/warp.h"

namespace warpscope {

/// Where the plane lies: as far as the middle of the volume, or so far that only turning the camera changes anything.
enum class PicturePlane { middle, infinity };
extern const Knob kPicturePlaneKnob;

extern const WarpDescriptor kRotateWarp;

}  // namespace warpscope
