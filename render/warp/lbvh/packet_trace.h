// Closest hits of all of a camera's rays through the hierarchy of lbvh.h, many rays at a time. Host only.
// Frustum and packet traversal after Wald, Boulos, Shirley 2007 ("Ray Tracing Deformable Scenes using Dynamic Bounding
// Volume Hierarchies"), but with planes through the eye instead of interval arithmetic.
#pragma once

#include <cstdint>
#include <stop_token>

#include "render/core/camera.h"
#include "render/core/image.h"
#include "render/warp/lbvh/lbvh.h"

namespace warpscope {

/// Writes for every pixel what closestHit, by that arithmetic (of capsules by the stable one), says of pixelRay through its centre, bit for bit: `ids` and, unless null,
/// `depth` (kNoHit where nothing is hit) take the camera's size. Throws OperationCancelled if `stop` is set.
void tracePackets(const GroupedLbvhView& view, const Camera& camera, Image<uint32_t>& ids, Image<float>* depth,
                  const std::stop_token& stop, Arithmetic arithmetic = Arithmetic::stable);

}  // namespace warpscope
