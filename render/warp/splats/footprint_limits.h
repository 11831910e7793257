// Which footprints are walked by whom on a device. Host and device.
// See footprint_walk.cuh.
#pragma once

#include <cstdint>

#include "render/core/host_device.h"

namespace warpscope {

/// Pixels of a footprint that a warp walks, beside those of its other spheres; more are for many blocks, because a warp has no more than its share of one multiprocessor.
inline constexpr uint32_t kPixelsOfWarp = 8192;

/// In which row of a footprint a pixel is, counted row by row from its first one; `perWidth`: 1.0f / its width. Exact for up to kPixelsOfWarp pixels: the product is off by less than 2^-22 times
/// itself, and half a pixel's share of a row lies between it and the next whole number.
WARPSCOPE_HD inline int rowOfPixel(uint32_t pixel, float perWidth) { return static_cast<int>((static_cast<float>(pixel) + 0.5f) * perWidth); }

}  // namespace warpscope
