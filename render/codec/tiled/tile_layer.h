// Which pixels of a tile have something in one layer, and which are next to each other: what both sides derive from the same numbers.
// As band_layout.h, within a tile, and with another rule for a pixel without neighbours: in its row the one before it that has something; where there is none,
// what the row above would take for the pixel to the right, and so on upward. So a row needs to know of the row above no more than one column ahead.
#pragma once

#include <cstdint>
#include <span>

#include "render/codec/band_layout.h"
#include "render/codec/tiled/tile_grid.h"
#include "render/core/transfer_vector.h"

namespace warpscope {

/// Keeps its buffers. Layers are gone through from the front.
class TileLayer {
 public:
  /// The front layer. `counts`: how many layers each pixel of the tile has, row by row; they stay where they are.
  void begin(const TileRect& tile, std::span<const uint8_t> counts);
  /// Goes on to the next layer. False if no pixel has one.
  bool goBehind();

  size_t size() const { return pixels_.size(); }
  /// Of each element: its pixel in the tile; its column and row in the picture.
  std::span<const uint32_t> pixels() const { return pixels_; }
  std::span<const uint32_t> columns() const { return columns_; }
  std::span<const uint32_t> rows() const { return rows_; }
  std::span<const Neighbors> neighbors() const { return neighbors_; }
  /// Which elements of the layer in front the layer's are behind; of the front layer all.
  std::span<const uint32_t> kept() const { return kept_; }

 private:
  void findNeighbors();
  uint32_t slotAbove(uint32_t x, uint32_t y) const;

  TileRect tile_;
  std::span<const uint8_t> counts_;
  uint32_t layer_ = 0;
  TransferVector<uint32_t> pixels_, columns_, rows_, kept_;
  TransferVector<uint32_t> slots_;      // of each pixel, with a column more on the left and a row more on top; 0 where there is nothing
  TransferVector<uint32_t> rowBegins_;  // of each row, and the end
  TransferVector<Neighbors> neighbors_;
};

}  // namespace warpscope
