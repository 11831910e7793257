// What the rays of a camera meet of a frame's segments, in figures: for people who want to know why a picture looks as it does. On the host.
#pragma once

#include <stop_token>

#include "render/core/camera.h"
#include "render/core/image.h"
#include "render/march/sample_frame.h"

namespace warpscope {

/// Both as large as the camera's picture.
struct SegmentLook {
  Image<float> count;  ///< segments that a pixel's ray goes through until hardly any light is left; 0 where it meets none
  Image<float> depth;  ///< from the eye, in volume units: the mean of where the segments' opacity is met, as it is seen; NaN where none is
};

/// Each segment is taken to be the same all over its pixel's frustum, whatever lies between rays otherwise (Between::nearest); of what no segment tells nothing is
/// met. The frame has segments. Throws OperationCancelled if `stop` is set.
SegmentLook lookAtSegments(const SampleFrame& frame, const Camera& camera, const std::stop_token& stop = {});

}  // namespace warpscope
