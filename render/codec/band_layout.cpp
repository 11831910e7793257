// Covered pixels in order.
// See band_layout.h.
#include "render/codec/band_layout.h"

#include <algorithm>
#include <bit>

namespace warpscope {

void BandLayout::build(uint32_t width, uint32_t firstRow, uint32_t rowCount, std::span<const uint8_t> mask) {
  size_t covered = 0;
  for (const uint8_t byte : mask) covered += static_cast<size_t>(std::popcount(byte));
  columns.resize(covered);
  rows.resize(covered);
  neighbors.resize(covered);
  area = {width, rowCount, 0, 0};
  above_.assign(size_t{width} + 1, 0);
  current_.assign(size_t{width} + 1, 0);

  const uint32_t rowBytes = (width + 7) / 8;
  // Locals: what is written cannot be what is read then.
  uint32_t* const column = columns.data();
  uint32_t* const rowOf = rows.data();
  Neighbors* const neighbor = neighbors.data();
  uint32_t sample = 0;
  for (uint32_t y = 0; y < rowCount; ++y) {
    const uint8_t* row = mask.data() + size_t{y} * rowBytes;
    std::fill(current_.begin(), current_.end(), 0u);
    const uint32_t* const above = above_.data();
    uint32_t* const current = current_.data();
    uint32_t lastX = width, lastSlot = 0;  // of the covered pixel before: its slot need not come back from memory
    bool isEmpty = true;
    for (uint32_t byte = 0; byte < rowBytes; ++byte) {
      if (row[byte] == 0) continue;
      isEmpty = false;
      area.x0 = std::min(area.x0, 8 * byte);
      area.x1 = std::max(area.x1, std::min(8 * byte + 8, width));
      for (uint32_t bits = row[byte]; bits != 0; bits &= bits - 1) {
        const uint32_t x = 8 * byte + static_cast<uint32_t>(std::countr_zero(bits));
        uint32_t west = x == lastX + 1 ? lastSlot : 0, north = above[x + 1], northWest = above[x];
        if (west == 0) west = north;
        if (north == 0) north = west;
        if (west == 0) west = north = sample;
        if (northWest == 0) northWest = north;
        column[sample] = x;
        rowOf[sample] = firstRow + y;
        neighbor[sample] = {west, north, northWest};
        lastX = x;
        lastSlot = ++sample;
        current[x + 1] = lastSlot;
      }
    }
    if (!isEmpty) {
      area.y0 = std::min(area.y0, y);
      area.y1 = y + 1;
    }
    std::swap(above_, current_);
  }
  if (covered == 0) area = {};
}

}  // namespace warpscope
