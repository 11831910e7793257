// Which thread works at which pixel: warps are tiles of 8 x 4 pixels, whose rays stay together; blocks are tiles side by side.
#pragma once

#include <cstdint>

#include "render/cuda/memory.h"

namespace warpscope {

constexpr unsigned kTileWidth = 8;
constexpr unsigned kTileHeight = 4;
constexpr unsigned kTilesPerBlock = 4;
constexpr unsigned kTileBlockThreads = 32 * kTilesPerBlock;

struct PixelPlace {
  uint32_t x, y;
};

/// Of this thread's tile: its first pixel.
__device__ inline PixelPlace tileOfThread(uint32_t firstRow) {
  return {(blockIdx.x * kTilesPerBlock + threadIdx.x / 32) * kTileWidth, firstRow + blockIdx.y * kTileHeight};
}

/// May lie beyond the image.
__device__ inline PixelPlace pixelOfThread(uint32_t firstRow) {
  const PixelPlace tile = tileOfThread(firstRow);
  const unsigned lane = threadIdx.x % 32;
  return {tile.x + lane % kTileWidth, tile.y + lane / kTileWidth};
}

/// Blocks for an image, or for `height` rows of one.
inline dim3 tileGrid(uint32_t width, uint32_t height) {
  return {cuda::blocksFor(width, kTileWidth * kTilesPerBlock), cuda::blocksFor(height, kTileHeight), 1};
}

}  // namespace warpscope
