// Which pixels of a band have a sample in one layer, and which samples are next to each other: what both sides derive from the same mask.
// Missing neighbours are replaced by others, so that predictions need not ask.
#pragma once

#include <cstdint>
#include <span>

#include "render/core/host_device.h"
#include "render/core/transfer_vector.h"

namespace warpscope {

/// Samples to predict from, as their number in the layer plus one: slot 0 stands for none and holds a zero.
struct Neighbors {
  uint32_t west, north, northWest;

  Neighbors furtherOn(uint32_t count) const { return {west + count, north + count, northWest + count}; }
  bool operator==(const Neighbors&) const = default;
};

/// Samples one after the other whose neighbours are one after the other as well, western ones those right before them. Alone a sample has any neighbours.
struct NeighborRun {
  uint32_t begin, size;  ///< number of the first; how many
  Neighbors first;       ///< of the first

  Neighbors at(uint32_t i) const { return first.furtherOn(i); }
};

/// The pixels that have samples, as a rectangle. x0 is a multiple of 8.
struct CoveredArea {
  uint32_t x0 = 0, y0 = 0, x1 = 0, y1 = 0;  ///< rows count from the band's first

  bool isEmpty() const { return x0 >= x1; }
  uint32_t width() const { return (x1 - x0 + 7) / 8 * 8; }  ///< whole bytes of the mask
  uint32_t height() const { return y1 - y0; }
};

struct BandLayout {
  TransferVector<uint32_t> columns, rows;  ///< pixel of each sample; rows count from the picture's first
  TransferVector<NeighborRun> runs;        ///< of all samples, one after the other
  CoveredArea area;

  size_t size() const { return columns.size(); }

  /// `mask` has a bit for each pixel of the band, the lowest first, whole bytes a row.
  void build(uint32_t width, uint32_t firstRow, uint32_t rowCount, std::span<const uint8_t> mask);

 private:
  TransferVector<uint32_t> above_, current_;  // slot of each column's sample, with one column more on the left
};

/// Median of two neighbours and the plane through three.
WARPSCOPE_HD inline int32_t predicted(int32_t west, int32_t north, int32_t northWest) {
  const int32_t low = west < north ? west : north, high = west < north ? north : west;
  const int32_t within = northWest < low ? low : northWest > high ? high : northWest;  // where the plane ends within both, which no sum of theirs overflows then
  return static_cast<int32_t>(static_cast<uint32_t>(west) + static_cast<uint32_t>(north) - static_cast<uint32_t>(within));
}

}  // namespace warpscope
