// A tile's pixels gone through by a warp, 32 at once.
// For .cu files.
#pragma once

#include "render/codec/tiled/device_lanes.cuh"
#include "render/codec/tiled/device_sheet.h"

namespace warpscope {

/// XOR of the values of all threads up to the calling one.
__device__ inline uint32_t prefixXor(uint32_t value) {
  for (uint32_t offset = 1; offset < 32; offset *= 2) {
    const uint32_t before = __shfl_up_sync(kAllLanes, value, offset);
    if (threadIdx.x % 32 >= offset) value ^= before;
  }
  return value;
}

/// Calls f(pixel, whether it is covered, which threads' are, how many covered ones are before it) for the pixels of the tile, 32 at once where any of them is covered; all
/// threads of a warp call f.
template <class F>
__device__ void forCovered(const SheetView& view, const TileRect& rect, const F& f) {
  uint32_t before = 0;
  for (uint32_t begin = 0; begin < rect.pixels(); begin += 32) {
    const uint32_t place = begin + threadIdx.x % 32;
    const bool isInside = place < rect.pixels();
    const size_t pixel = isInside ? view.pixel(rect, place % rect.width, place / rect.width) : 0;
    const bool isCovered = isInside && view.counts[pixel] > 0;
    const uint32_t covered = __ballot_sync(kAllLanes, isCovered);
    if (covered != 0) f(pixel, isCovered, covered, before + __popc(covered & lanesBelow()));
    before += __popc(covered);
  }
}

}  // namespace warpscope
