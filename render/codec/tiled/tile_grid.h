// How a picture is cut for the format `tiled`: pieces that processors of any kind code side by side.
// A tile has a row for each thread of a GPU's warp. Larger ones know more of their pixels' neighbours, smaller ones keep more threads busy: 256 columns take 1 to 4 % fewer
// bytes, and a device three times as long.
#pragma once

#include <cstddef>
#include <cstdint>

#include "render/core/host_device.h"

namespace warpscope {

inline constexpr uint32_t kCodedTileWidth = 64, kCodedTileHeight = 32;

struct TileRect {
  uint32_t x0 = 0, y0 = 0;
  uint32_t width = 0, height = 0;  ///< at least 1, at most kCodedTileWidth and kCodedTileHeight

  WARPSCOPE_HD uint32_t pixels() const { return width * height; }
  /// Of a mask with a bit a pixel.
  WARPSCOPE_HD uint32_t maskRowBytes() const { return (width + 7) / 8; }
};

/// Plain data, for host and device. Tiles row by row.
struct TileGrid {
  uint32_t width = 0, height = 0;  ///< of the picture

  WARPSCOPE_HD uint32_t columns() const { return (width + kCodedTileWidth - 1) / kCodedTileWidth; }
  WARPSCOPE_HD uint32_t count() const { return columns() * ((height + kCodedTileHeight - 1) / kCodedTileHeight); }
  WARPSCOPE_HD TileRect at(uint32_t tile) const {
    const uint32_t x0 = tile % columns() * kCodedTileWidth, y0 = tile / columns() * kCodedTileHeight;
    return {x0, y0, width - x0 < kCodedTileWidth ? width - x0 : kCodedTileWidth, height - y0 < kCodedTileHeight ? height - y0 : kCodedTileHeight};
  }
};

}  // namespace warpscope
