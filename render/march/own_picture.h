// What is seen in each pixel of a frame's own picture: the rays of its samples, and their colours.
// Samples say which pixel their ray went through. Of several rays in one pixel, which no marcher makes, the one whose first sample is nearest is
// seen.
#pragma once

#include "render/core/image.h"
#include "render/march/sample_frame.h"

namespace warpscope {

/// An image of the size of the frame's camera: index of the first sample of the ray that is seen, kNoSample where there is none.
Image<uint32_t> ownPicture(const SampleFrame& frame);

/// Gives every pixel the colours of its ray's samples over one another, linear and premultiplied, 0 where there is none; resizes `color`.
/// `rays` holds indices of rays' first samples, as ownPicture() does.
void resolveRayColors(const SampleFrame& frame, const Image<uint32_t>& rays, Image<glm::vec4>& color);

}  // namespace warpscope
