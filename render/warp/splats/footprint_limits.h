// Which footprints are walked by whom on a device. Host and device.
// See footprint_walk.cuh.
#pragma once

#include <cstdint>

namespace warpscope {

/// Pixels that one thread walks alone, whatever its neighbours do.
inline constexpr uint32_t kPixelsAlone = 64;
/// Pixels that one thread walks alone if its neighbours have as much to do; beyond, lanes side by side read memory better.
inline constexpr uint32_t kPixelsBeside = 256;
/// Pixels that one warp walks; more are for many blocks, because a warp has no more than its share of one multiprocessor.
inline constexpr uint32_t kPixelsOfWarp = 8192;

}  // namespace warpscope
