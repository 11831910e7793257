// Segments that a SegmentBatchMerger holds into the codes that a frame has: segment_encoder.h, of all rays side by side.
#pragma once

#include "render/march/finished_ray.h"
#include "render/march/segment_batch_merger.h"

namespace warpscope {

/// Of the rays in the first so many lanes. `cosines`: a ray's each; `normals`: of their segments by their numbers, null where none are sent; `encoded`: as many as rays.
void encodeSegments(const SegmentBatchMerger& merger, int rays, const float* cosines, const SampleQuantization& quantization, const NormalCode* const* normals,
                    EncodedSegments* const* encoded);

}  // namespace warpscope
