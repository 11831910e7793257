// What kernels of samples and of segments share between values and planes.
// For one .cu file.
#pragma once

#include <cstdint>

#include "render/codec/bytes.h"
#include "render/codec/pixel_places.h"
#include "render/codec/tiled/device_fronts.cuh"
#include "render/codec/tiled/device_sheet.h"
#include "render/codec/tokens.h"

namespace warpscope {
namespace {

__device__ int32_t sumOf(int32_t a, int32_t b) { return static_cast<int32_t>(static_cast<uint32_t>(a) + static_cast<uint32_t>(b)); }
__device__ int32_t differenceOf(int32_t a, int32_t b) { return static_cast<int32_t>(static_cast<uint32_t>(a) - static_cast<uint32_t>(b)); }

/// Where the calling thread's row of a tile has its values.
struct RowCursor {
  uint32_t first = 0;  ///< of the next pixel, among the frame's
  uint32_t at = 0;     ///< of the next value of the stream, among all
  uint32_t own = 0;    ///< first of the pixel at work

  /// Of a layer of a tile; all threads of a warp must call.
  __device__ static RowCursor of(const SheetView& view, const TileRect& rect, uint32_t stream) {
    const uint32_t row = threadIdx.x % 32, layer = stream % view.layers;
    uint32_t covered = 0;
    if (row < rect.height) {
      const uint8_t* const counts = view.counts + view.pixel(rect, 0, row);
      for (uint32_t x = 0; x < rect.width; ++x) covered += counts[x] > layer ? 1 : 0;
    }
    uint32_t before = covered;
    for (uint32_t offset = 1; offset < 32; offset *= 2) {
      const uint32_t other = __shfl_up_sync(kAllLanes, before, offset);
      if (row >= offset) before += other;
    }
    return {row < rect.height ? view.rowBegin(rect, row) : 0, view.begins[stream] + before - covered, 0};
  }
  /// For every pixel of the row, from the left to the right: whether the layer covers it.
  __device__ bool goOn(uint32_t count, uint32_t layer) {
    own = first;
    first += count;
    return count > layer;
  }
};

/// Differences of colours from what is likely, and back: color_differences.h.
__device__ void putColor(const SheetView& view, uint32_t alphaPlane, const FrontNeighbors& from, uint32_t color, uint32_t at) {
  const auto difference = [&](int shift) { return static_cast<int32_t>(color >> shift & 255) - predictedChannel(from, &FrontValues::color, shift); };
  const int32_t green = difference(8);
  const auto put = [&](uint32_t plane, int32_t value) { view.bytes[size_t{alphaPlane + plane} * view.values + at] = static_cast<uint8_t>(value); };
  put(0, difference(24));
  put(1, green);
  put(2, difference(0) - green);
  put(3, difference(16) - green);
}
__device__ uint32_t takeColor(const SheetView& view, uint32_t alphaPlane, const FrontNeighbors& from, uint32_t at) {
  const auto byte = [&](uint32_t plane) { return static_cast<int32_t>(view.bytes[size_t{alphaPlane + plane} * view.values + at]); };
  const auto channel = [&](int shift, int32_t difference) { return static_cast<uint32_t>((predictedChannel(from, &FrontValues::color, shift) + difference) & 255) << shift; };
  const int32_t green = byte(1);
  return channel(24, byte(0)) | channel(8, green) | channel(0, byte(2) + green) | channel(16, byte(3) + green);
}

/// Origins of places of pixels that are covered. A thread for each pixel.
__global__ void findOrigins(PathGrid paths, SheetView view, int32_t* origins) {
  const uint32_t pixel = blockIdx.x * blockDim.x + threadIdx.x;
  if (pixel >= view.grid.width * view.grid.height || view.counts[pixel] == 0) return;
  origins[pixel] = paths.path(pixel % view.grid.width, pixel / view.grid.width).origin;
}

/// The sum of all threads' hashes.
__device__ void addHash(uint64_t own, unsigned long long* hash) {
  for (int offset = 16; offset > 0; offset /= 2) own += __shfl_xor_sync(kAllLanes, own, offset);
  if (threadIdx.x % 32 == 0 && own != 0) atomicAdd(hash, static_cast<unsigned long long>(own));
}

}  // namespace
}  // namespace warpscope
