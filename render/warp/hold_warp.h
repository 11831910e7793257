// The frame's image as it was, whatever the camera does now.
// What viewers that stream images show until the next image comes. Several samples of a ray are seen over one another: march/own_picture.h.
#pragma once

#include "render/warp/warp.h"

namespace warpscope {

extern const WarpDescriptor kHoldWarp;

}  // namespace warpscope
