// The k nearest spheres along each of a camera's rays, composited. Host only; the hierarchy is the one of lbvh.h.
// Multi-hit traversal after Gribble, Naveros, Kerzner 2014, "Multi-Hit Ray Traversal", JCGT 3(1); compositing: Porter, Duff 1984.
#pragma once

#include <cstdint>
#include <span>
#include <stop_token>

#include "render/core/camera.h"
#include "render/core/color.h"
#include "render/core/image.h"
#include "render/warp/lbvh/lbvh.h"
#include "render/warp/multihit/nearest_hits.h"

namespace warpscope {

/// For every pixel of `camera` (see isUsable) the first `hits` (1..kMaxHits, else std::invalid_argument) spheres along its ray, ordered by
/// (distance, id): `ids` takes the first one's id, kNoSample where there is none, and `color` their colours over each other, the nearest in
/// front, 0 where there is none. `colors` has one entry for each sphere of the cloud that was built. Both images take the camera's size.
/// Throws OperationCancelled if `stop` is set; the images are then incomplete.
void traceNearestHits(const GroupedLbvhView& view, std::span<const Rgba8> colors, const Camera& camera, int hits, Image<uint32_t>& ids,
                      Image<glm::vec4>& color, const std::stop_token& stop);

}  // namespace warpscope
