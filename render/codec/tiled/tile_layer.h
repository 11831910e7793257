// Which pixels of a tile have something in one layer, and which are next to each other: what both sides derive from the same numbers.
// As band_layout.h, within a tile, and with another rule for a pixel without neighbours: in its row the one before it that has something; where there is none,
// what the row above would take for the pixel to the right, and so on upward. So a row needs to know of the row above no more than one column ahead.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "render/codec/band_layout.h"
#include "render/codec/neighbor_runs.h"
#include "render/codec/tiled/tile_grid.h"
#include "render/core/transfer_vector.h"

namespace warpscope {

/// Keeps its buffers. Layers are gone through from the front.
class TileLayer {
 public:
  /// The front layer. `counts`: how many layers each pixel of the tile has, row by row; they stay where they are. The tile is one of a grid's.
  void begin(const TileRect& tile, std::span<const uint8_t> counts);
  /// Goes on to the next layer. False if no pixel has one; the layer is no longer to be used then.
  bool goBehind();

  size_t size() const { return columns_.size(); }
  /// An element's pixel in the tile.
  uint32_t pixelOf(size_t k) const { return (rows_[k] - tile_.y0) * tile_.width + columns_[k] - tile_.x0; }
  /// Of each element: its column and row in the picture.
  std::span<const uint32_t> columns() const { return columns_; }
  std::span<const uint32_t> rows() const { return rows_; }
  /// Of all elements, one after the other.
  std::span<const NeighborRun> runs() const { return runs_; }
  /// Of all elements, one after the other: runs(part of runs()) and, of rows that are covered all over below such rows, rows(NeighborRows).
  template <class Runs, class Rows>
  void forEachPart(const Runs& runs, const Rows& rows) const {
    const std::span<const NeighborRun> all = runs_;
    size_t done = 0;
    for (const FullRows& full : fullRows_) {
      const uint32_t count = full.rows.count / kRowsAtOnce * kRowsAtOnce;
      if (count == 0) continue;
      runs(all.subspan(done, full.firstRun - done));
      rows(NeighborRows{full.rows.begin, full.rows.width, count});
      done = full.firstRun + size_t{2} * count;  // the first of each row is a run of its own
    }
    runs(all.subspan(done));
  }
  /// Which columns of a row of the tile have an element, the first in the lowest bit.
  uint64_t maskOf(uint32_t row) const { return masks_[row]; }
  /// Which elements of the layer in front the layer's are behind. Not of the front layer.
  std::span<const uint32_t> kept() const { return kept_; }

 private:
  struct FullRows {
    size_t firstRun;
    NeighborRows rows;
  };

  void findRuns();
  void addFullRow(uint32_t k);
  uint32_t slotAt(uint32_t x, uint32_t y) const;
  Neighbors neighborsAt(uint32_t x, uint32_t y, uint32_t k) const;
  uint32_t slotAbove(uint32_t x, uint32_t y) const;

  TileRect tile_;
  std::span<const uint8_t> counts_;
  uint32_t layer_ = 0;
  uint8_t deepest_ = 0;  // how many layers there are
  TransferVector<uint32_t> columns_, rows_, kept_;
  std::array<uint64_t, kCodedTileHeight> masks_{};      // of each row
  std::array<uint32_t, kCodedTileHeight> rowBegins_{};  // of each row, its first element
  TransferVector<NeighborRun> runs_;
  std::vector<FullRows> fullRows_;
};

}  // namespace warpscope
