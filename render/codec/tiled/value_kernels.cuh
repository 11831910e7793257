// What kernels of samples and of segments share: all values of a picture, each by its place in its frame and in its stream.
// For one .cu file.
#pragma once

#include <cstdint>

#include "render/codec/bytes.h"
#include "render/codec/tiled/device_hash.cuh"
#include "render/codec/tiled/device_lanes.cuh"
#include "render/codec/tiled/device_sheet.h"
#include "render/codec/tiled/tile_fronts.h"
#include "render/codec/tokens.h"
#include "render/march/pixel_places.h"

namespace warpscope {
namespace {

/// A block for each row of each tile, a thread for each pixel.
inline dim3 rowsOfTiles(const SheetView& view) { return {view.tiles(), kCodedTileHeight}; }

/// Calls f(pixel's path, layer, value's number in the frame, among all streams) for each layer of the calling thread's pixel, from the front.
template <class F>
__device__ void forValues(const PathGrid& paths, const SheetView& view, const F& f) {
  constexpr uint32_t kWarps = kCodedTileWidth / 32, kMost = 32;
  __shared__ uint32_t covered[kMost][kWarps];
  const TileRect rect = view.grid.at(blockIdx.x);
  const uint32_t x = threadIdx.x, y = blockIdx.y, warp = x / 32;
  if (y >= rect.height) return;
  const uint32_t count = x < rect.width ? min(static_cast<uint32_t>(view.counts[view.pixel(rect, x, y)]), view.layers) : 0;
  for (uint32_t layer = 0; layer < view.layers; ++layer) {
    const uint32_t own = __ballot_sync(kAllLanes, count > layer);
    if (x % 32 == 0) covered[layer][warp] = __popc(own);
  }
  __syncthreads();
  const auto before = [&](uint32_t layer) {
    uint32_t sum = __popc(__ballot_sync(kAllLanes, count > layer) & lanesBelow());
    for (uint32_t left = 0; left < warp; ++left) sum += covered[layer][left];
    return sum;
  };
  uint32_t first = view.rowBegin(rect, y);
  for (uint32_t layer = 0; layer < view.layers; ++layer) first += before(layer);
  PixelPath path;
  if (count > 0) path = paths.path(rect.x0 + x, rect.y0 + y);
  for (uint32_t layer = 0; __any_sync(kAllLanes, layer < count); ++layer) {
    const uint32_t stream = blockIdx.x * view.layers + layer, rank = before(layer);
    if (layer < count) f(path, layer, first + layer, view.begins[stream] + view.rowRanks[size_t{stream} * kCodedTileHeight + y] + rank);
  }
}

/// Origins of values' rays, in the order of streams.
__global__ void __launch_bounds__(kCodedTileWidth) findOrigins(PathGrid paths, SheetView view, int32_t* origins) {
  if (!view.isFull() || *view.flags != 0) return;
  forValues(paths, view, [&](const PixelPath& path, uint32_t, uint32_t, uint32_t at) { origins[at] = path.origin; });
}

}  // namespace
}  // namespace warpscope
