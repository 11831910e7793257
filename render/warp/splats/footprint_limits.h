// Which footprints are walked by whom on a device. Host and device.
// See footprint_walk.cuh.
#pragma once

#include <cstdint>

namespace warpscope {

/// Pixels of a footprint that a warp walks, beside those of its other spheres; more are for many blocks, because a warp has no more than its share of one multiprocessor.
inline constexpr uint32_t kPixelsOfWarp = 8192;

}  // namespace warpscope
