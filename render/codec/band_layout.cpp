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
  runs.clear();
  area = {width, rowCount, 0, 0};
  above_.assign(size_t{width} + 1, 0);
  current_.assign(size_t{width} + 1, 0);

  const uint32_t rowBytes = (width + 7) / 8;
  // Locals: what is written cannot be what is read then.
  uint32_t* const column = columns.data();
  uint32_t* const rowOf = rows.data();
  NeighborRun run{0, 0, {}};
  const auto addRun = [&](uint32_t begin, uint32_t size, const Neighbors& first) {
    if (first.west == begin && first == run.at(run.size)) {
      run.size += size;
      return;
    }
    if (run.size > 0) runs.push_back(run);
    run = {begin, size, first};
  };
  uint32_t sample = 0;
  for (uint32_t y = 0; y < rowCount; ++y) {
    const uint8_t* const row = mask.data() + size_t{y} * rowBytes;
    const uint8_t* const rowAbove = y > 0 ? row - rowBytes : nullptr;
    std::fill(current_.begin(), current_.end(), 0u);
    const uint32_t* const above = above_.data();
    uint32_t* const current = current_.data();
    uint32_t lastX = width, lastSlot = 0;  // of the covered pixel before: its slot need not come back from memory
    bool isEmpty = true;
    for (uint32_t byte = 0; byte < rowBytes; ++byte) {
      if (row[byte] == 0) continue;
      isEmpty = false;
      const uint32_t x0 = 8 * byte;
      area.x0 = std::min(area.x0, x0);
      area.x1 = std::max(area.x1, std::min(x0 + 8, width));
      if (row[byte] == 0xff && rowAbove != nullptr && rowAbove[byte] == 0xff && x0 == lastX + 1 && above[x0] != 0) {  // all neighbours are there
        addRun(sample, 8, {sample, above[x0 + 1], above[x0]});
        for (uint32_t i = 0; i < 8; ++i) {
          column[sample + i] = x0 + i;
          rowOf[sample + i] = firstRow + y;
          current[x0 + i + 1] = sample + i + 1;
        }
        lastX = x0 + 7;
        lastSlot = sample += 8;
        continue;
      }
      for (uint32_t bits = row[byte]; bits != 0; bits &= bits - 1) {
        const uint32_t x = x0 + static_cast<uint32_t>(std::countr_zero(bits));
        uint32_t west = x == lastX + 1 ? lastSlot : 0, north = above[x + 1], northWest = above[x];
        if (west == 0) west = north;
        if (north == 0) north = west;
        if (west == 0) west = north = sample;
        if (northWest == 0) northWest = north;
        column[sample] = x;
        rowOf[sample] = firstRow + y;
        addRun(sample, 1, {west, north, northWest});
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
  if (run.size > 0) runs.push_back(run);
  if (covered == 0) area = {};
}

}  // namespace warpscope
