// How uncertain depth is, pixel by pixel: what the plane "spread" of a frame says, as an image.
// Of several samples in one pixel the nearest is shown.
#pragma once

#include "render/core/image.h"
#include "render/march/sample_frame.h"

namespace warpscope {

/// Of the size of the frame's camera, in volume units, 0 where there is no sample. Throws InputError if the frame has no plane kSpreadPlane, or one whose
/// values are no lengths.
Image<float> spreadMap(const SampleFrame& frame);

}  // namespace warpscope
