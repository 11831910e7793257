// Where what is in a tile's rows is among all that a frame has, which is row by row of the whole picture.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "render/codec/tiled/tile_grid.h"
#include "render/core/transfer_vector.h"

namespace warpscope {

struct RowPart {
  uint32_t begin = 0, end = 0;
};

/// Of each pixel of a tile that has anything, where its first is among the frame's.
inline void findFirsts(std::span<const uint8_t> counts, const TileRect& rect, std::span<const RowPart> rows, TransferVector<uint32_t>& firsts) {
  firsts.resize(rect.pixels());  // at most
  uint32_t* const first = firsts.data();
  const uint8_t* count = counts.data();
  size_t k = 0;
  for (uint32_t y = 0; y < rect.height; ++y) {
    uint32_t at = rows[y].begin;
    for (uint32_t x = 0; x < rect.width; ++x, ++count) {
      first[k] = at;  // one that has nothing is written over
      k += *count > 0 ? 1 : 0;
      at += *count;
    }
  }
  firsts.resize(k);
}

class TileRows {
 public:
  /// Of a grid; nothing is anywhere yet.
  void begin(const TileGrid& grid) {
    grid_ = grid;
    parts_.assign(size_t{grid.count()} * kCodedTileHeight, {});
  }
  std::span<RowPart> of(size_t tile) { return std::span(parts_).subspan(tile * kCodedTileHeight, kCodedTileHeight); }
  std::span<const RowPart> of(size_t tile) const { return std::span(parts_).subspan(tile * kCodedTileHeight, kCodedTileHeight); }

  /// Makes places of parts that begin at 0. Returns how much there is in all.
  size_t place() {
    size_t at = 0;
    for (uint32_t row = 0; row < grid_.height; ++row)
      for (uint32_t column = 0; column < grid_.columns(); ++column) {
        RowPart& own = parts_[(size_t{row / kCodedTileHeight} * grid_.columns() + column) * kCodedTileHeight + row % kCodedTileHeight];
        const size_t count = own.end;
        own.begin = static_cast<uint32_t>(at);
        at += count;
        own.end = static_cast<uint32_t>(at);
      }
    return at;
  }

 private:
  TileGrid grid_;
  std::vector<RowPart> parts_;  // kCodedTileHeight of each tile
};

}  // namespace warpscope
