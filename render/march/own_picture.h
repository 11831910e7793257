// Which of a frame's samples is seen in each pixel of the frame's own picture.
// A frame does not say which pixel a sample came from, but its camera does; of several that share a pixel the nearest is seen.
#pragma once

#include "render/core/image.h"
#include "render/march/sample_frame.h"

namespace warpscope {

/// An image of the size of the frame's camera: index of the sample, kNoSample where there is none.
Image<uint32_t> ownPicture(const SampleFrame& frame);

}  // namespace warpscope
