// Which thread works at which pixel: warps are tiles of 8 x 4 pixels, whose rays stay together; blocks are tiles side by side, or two by two.
#pragma once

#include <cstdint>

#include "render/core/camera.h"
#include "render/cuda/memory.h"

namespace warpscope {

constexpr unsigned kTileWidth = 8;
constexpr unsigned kTileHeight = 4;
constexpr unsigned kTilesPerBlock = 4;
constexpr unsigned kTileBlockThreads = 32 * kTilesPerBlock;

struct PixelPlace {
  uint32_t x, y;
};

/// Of this thread's tile: its first pixel. Tiles may be several times as high, each lane then having as many pixels, kTileHeight apart.
__device__ inline PixelPlace tileOfThread(uint32_t firstRow, unsigned pixelsPerLane = 1) {
  return {(blockIdx.x * kTilesPerBlock + threadIdx.x / 32) * kTileWidth, firstRow + blockIdx.y * kTileHeight * pixelsPerLane};
}

/// The lane's k-th pixel of a tile. May lie beyond the image.
__device__ inline PixelPlace pixelOfTile(const PixelPlace& tile, unsigned k = 0) {
  const unsigned lane = threadIdx.x % 32;
  return {tile.x + lane % kTileWidth, tile.y + k * kTileHeight + lane / kTileWidth};
}

__device__ inline PixelPlace pixelOfThread(uint32_t firstRow) { return pixelOfTile(tileOfThread(firstRow)); }

/// For kernels whose threads take the longer the nearer they are to the picture's middle: blocks are two by two tiles, and those of the middle rows (of
/// what is launched at once) come first, so that short ones are left for the end, when not all of the device has work.
constexpr unsigned kSquareTiles = 2;
static_assert(kSquareTiles * kSquareTiles == kTilesPerBlock);

__device__ inline PixelPlace pixelOfSquare(uint32_t firstRow) {
  const int y = static_cast<int>(blockIdx.y), rows = static_cast<int>(gridDim.y);
  const int row = (rows - 1) / 2 + (y % 2 == 1 ? (y + 1) / 2 : -(y / 2));
  const unsigned tile = threadIdx.x / 32;
  return pixelOfTile({(blockIdx.x * kSquareTiles + tile % kSquareTiles) * kTileWidth,
                      firstRow + (static_cast<uint32_t>(row) * kSquareTiles + tile / kSquareTiles) * kTileHeight});
}

/// The ray through a pixel's centre.
__device__ inline Ray rayOfPixel(const Camera& camera, const PixelPlace& pixel) {
  return pixelRay(camera, {static_cast<float>(pixel.x) + 0.5f, static_cast<float>(pixel.y) + 0.5f});
}

/// Blocks for an image, or for `height` rows of one, whose threads ask pixelOfSquare().
inline dim3 squareGrid(uint32_t width, uint32_t height) {
  return {cuda::blocksFor(width, kTileWidth * kSquareTiles), cuda::blocksFor(height, kTileHeight * kSquareTiles), 1};
}

/// Blocks for an image, or for `height` rows of one.
inline dim3 tileGrid(uint32_t width, uint32_t height, unsigned pixelsPerLane = 1) {
  return {cuda::blocksFor(width, kTileWidth * kTilesPerBlock), cuda::blocksFor(height, kTileHeight * pixelsPerLane), 1};
}

}  // namespace warpscope
