// Where what is in a tile's rows is among all that a frame has, which is row by row of the whole picture.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "render/codec/tiled/tile_grid.h"

namespace warpscope {

struct RowPart {
  uint32_t begin = 0, end = 0;
};

class TileRows {
 public:
  /// Of a grid; nothing is anywhere yet.
  void begin(const TileGrid& grid) {
    grid_ = grid;
    parts_.assign(size_t{grid.count()} * kTileHeight, {});
  }
  std::span<RowPart> of(size_t tile) { return std::span(parts_).subspan(tile * kTileHeight, kTileHeight); }
  std::span<const RowPart> of(size_t tile) const { return std::span(parts_).subspan(tile * kTileHeight, kTileHeight); }

  /// Makes places of parts that begin at 0. Returns how much there is in all.
  size_t place() {
    size_t at = 0;
    for (uint32_t row = 0; row < grid_.height; ++row)
      for (uint32_t column = 0; column < grid_.columns(); ++column) {
        RowPart& own = parts_[(size_t{row / kTileHeight} * grid_.columns() + column) * kTileHeight + row % kTileHeight];
        const size_t count = own.end;
        own.begin = static_cast<uint32_t>(at);
        at += count;
        own.end = static_cast<uint32_t>(at);
      }
    return at;
  }

 private:
  TileGrid grid_;
  std::vector<RowPart> parts_;  // kTileHeight of each tile
};

}  // namespace warpscope
