// Which footprints are walked by whom on a device. Host and device.
// See footprint_walk.cuh.
#pragma once

#include <cstdint>

namespace warpscope {

/// Pixels that one warp walks; more are for many blocks, because a warp has no more than its share of one multiprocessor.
inline constexpr uint32_t kPixelsOfWarp = 8192;

}  // namespace warpscope
