// Pixels in order, and their neighbours, from masks of rows.
// See tile_layer.h.
#include "render/codec/tiled/tile_layer.h"

#include <algorithm>
#include <bit>

#include "render/codec/tiled/byte_block.h"
#include "render/codec/tiled/covered_bits.h"

namespace warpscope {
namespace {

static_assert(kCodedTileWidth == 64, "a row's mask is a word");

/// The lowest bits.
uint64_t lowBits(uint32_t count) { return count < 64 ? (uint64_t{1} << count) - 1 : ~uint64_t{0}; }

uint64_t covered(const uint8_t* counts, uint32_t width) {
#ifdef WARPSCOPE_HAS_BYTE_BLOCKS
  if (width == ByteBlock::kSize) return ~ByteBlock(counts).equalTo(0);
#endif
  uint64_t mask = 0;
  for (uint32_t x = 0; x < width; x += 8) mask |= uint64_t{coveredBits(counts + x, std::min(width - x, 8u))} << x;
  return mask;
}

/// Of a row that is covered all over.
void fillRow(uint32_t width, uint32_t column, uint32_t row, uint32_t* __restrict__ columns, uint32_t* __restrict__ rows) {
  for (uint32_t x = 0; x < width; ++x) {
    columns[x] = column + x;
    rows[x] = row;
  }
}

}  // namespace

void TileLayer::begin(const TileRect& tile, std::span<const uint8_t> counts) {
  tile_ = tile;
  counts_ = counts;
  layer_ = 0;
  uint8_t deepest = 0;
  for (const uint8_t count : counts) deepest = count > deepest ? count : deepest;
  deepest_ = deepest;
  for (TransferVector<uint32_t>* values : {&columns_, &rows_}) values->resize(counts.size());  // at most
  kept_.clear();
  // Locals: what is written cannot be what is read then.
  uint32_t* const columnOf = columns_.data();
  uint32_t* const rowOf = rows_.data();
  uint32_t k = 0;
  for (uint32_t y = 0; y < tile.height; ++y) {
    masks_[y] = covered(counts.data() + size_t{y} * tile.width, tile.width);
    rowBegins_[y] = k;
    if (masks_[y] == lowBits(tile.width)) {
      fillRow(tile.width, tile.x0, tile.y0 + y, columnOf + k, rowOf + k);
      k += tile.width;
      continue;
    }
    for (uint64_t bits = masks_[y]; bits != 0; bits &= bits - 1) {
      columnOf[k] = tile.x0 + static_cast<uint32_t>(std::countr_zero(bits));
      rowOf[k] = tile.y0 + y;
      ++k;
    }
  }
  for (TransferVector<uint32_t>* values : {&columns_, &rows_}) values->resize(k);
  findRuns();
}

bool TileLayer::goBehind() {
  ++layer_;
  if (layer_ >= deepest_) return false;
  const size_t before = columns_.size();
  kept_.resize(before);  // at most
  std::fill_n(masks_.begin(), tile_.height, uint64_t{0});
  uint32_t left = 0, row = 0;
  rowBegins_[0] = 0;
  for (uint32_t k = 0; k < before; ++k) {
    while (row < rows_[k] - tile_.y0) rowBegins_[++row] = left;
    if (counts_[pixelOf(k)] <= layer_) continue;
    masks_[row] |= uint64_t{1} << (columns_[k] - tile_.x0);
    columns_[left] = columns_[k];
    rows_[left] = rows_[k];
    kept_[left] = k;
    ++left;
  }
  while (row + 1 < tile_.height) rowBegins_[++row] = left;
  for (TransferVector<uint32_t>* values : {&columns_, &rows_, &kept_}) values->resize(left);
  findRuns();
  return true;
}

void TileLayer::findRuns() {
  runs_.clear();
  fullRows_.clear();
  const uint64_t full = lowBits(tile_.width);
  for (uint32_t y = 0; y < tile_.height; ++y) {
    const uint64_t own = masks_[y], above = y > 0 ? masks_[y - 1] : 0;
    const uint64_t hasWest = own & own << 1;
    const uint64_t isAmidst = hasWest & above & above << 1, isAlone = hasWest & ~above & ~(above << 1);  // all three neighbours are there, or the western one alone
    uint32_t k = rowBegins_[y];
    if (own == full && above == full && tile_.width % kRowsAtOnce == 0) addFullRow(k);
    for (uint64_t bits = own; bits != 0;) {
      const auto x = static_cast<uint32_t>(std::countr_zero(bits));
      NeighborRun run{k, 1, {k, k, k}};
      if ((isAmidst >> x & 1) != 0) {
        run.size = static_cast<uint32_t>(std::countr_one(isAmidst >> x));
        run.first.north = slotAt(x, y - 1);
        run.first.northWest = run.first.north - 1;
      } else if ((isAlone >> x & 1) != 0) {
        run.size = static_cast<uint32_t>(std::countr_one(isAlone >> x));
      } else {
        run.first = neighborsAt(x, y, k);
      }
      runs_.push_back(run);
      k += run.size;
      bits &= ~(lowBits(run.size) << x);
    }
  }
}

/// Whose first element is `k`, and whose runs are the next ones.
void TileLayer::addFullRow(uint32_t k) {
  if (fullRows_.empty() || fullRows_.back().rows.begin + fullRows_.back().rows.count * tile_.width != k) fullRows_.push_back({runs_.size(), {k, tile_.width, 0}});
  ++fullRows_.back().rows.count;
}

/// Of a pixel that has one, or 0.
uint32_t TileLayer::slotAt(uint32_t x, uint32_t y) const {
  if ((masks_[y] >> x & 1) == 0) return 0;
  return rowBegins_[y] + static_cast<uint32_t>(std::popcount(masks_[y] & lowBits(x))) + 1;
}

/// Of the pixel, whose element is `k`.
Neighbors TileLayer::neighborsAt(uint32_t x, uint32_t y, uint32_t k) const {
  uint32_t west = x > 0 && (masks_[y] >> (x - 1) & 1) != 0 ? k : 0;
  uint32_t north = y > 0 ? slotAt(x, y - 1) : 0;
  if (west == 0) west = north;
  if (north == 0) north = west;
  if (west == 0) west = north = k > rowBegins_[y] ? k : slotAbove(x, y);
  const uint32_t northWest = x > 0 && y > 0 ? slotAt(x - 1, y - 1) : 0;
  return {west, north, northWest == 0 ? north : northWest};
}

/// Of a pixel that is the first of its row and has no neighbours.
uint32_t TileLayer::slotAbove(uint32_t x, uint32_t y) const {
  while (y > 0) {
    --y;
    ++x;
    if (const uint64_t upTo = masks_[y] & lowBits(x + 1)) return rowBegins_[y] + static_cast<uint32_t>(std::popcount(upTo));
  }
  return 0;
}

}  // namespace warpscope
