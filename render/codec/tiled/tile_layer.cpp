// Pixels in order, and their neighbours.
// See tile_layer.h.
#include "render/codec/tiled/tile_layer.h"

#include <algorithm>
#include <bit>
#include <numeric>

#include "render/codec/tiled/covered_bits.h"

namespace warpscope {
namespace {

/// Of pixels beside one another, all but the first, whose number in the layer is `first`. Slots are those of the first, and of the pixel above it.
void findInRun(const uint32_t* __restrict__ above, uint32_t* __restrict__ own, uint32_t first, uint32_t count, Neighbors* __restrict__ neighbors) {
  for (uint32_t i = 1; i < count; ++i) {
    const uint32_t west = first + i;
    const uint32_t north = above[i] == 0 ? west : above[i];
    neighbors[i] = {west, north, above[i - 1] == 0 ? north : above[i - 1]};
    own[i] = west + 1;
  }
}

}  // namespace

void TileLayer::begin(const TileRect& tile, std::span<const uint8_t> counts) {
  tile_ = tile;
  counts_ = counts;
  layer_ = 0;
  for (TransferVector<uint32_t>* values : {&pixels_, &columns_, &rows_, &kept_}) values->resize(counts.size());  // at most
  // Locals: what is written cannot be what is read then.
  const uint8_t* const count = counts.data();
  uint32_t* const pixelOf = pixels_.data();
  uint32_t* const columnOf = columns_.data();
  uint32_t* const rowOf = rows_.data();
  uint32_t k = 0;
  for (uint32_t y = 0; y < tile.height; ++y)
    for (uint32_t begin = 0; begin < tile.width; begin += 8) {
      const uint32_t first = y * tile.width + begin;
      uint32_t bits = coveredBits(count + first, std::min(tile.width - begin, 8u));
      if (bits == 0xff) {
        for (uint32_t i = 0; i < 8; ++i) {
          pixelOf[k + i] = first + i;
          columnOf[k + i] = tile.x0 + begin + i;
          rowOf[k + i] = tile.y0 + y;
        }
        k += 8;
        continue;
      }
      for (; bits != 0; bits &= bits - 1) {
        const auto i = static_cast<uint32_t>(std::countr_zero(bits));
        pixelOf[k] = first + i;
        columnOf[k] = tile.x0 + begin + i;
        rowOf[k] = tile.y0 + y;
        ++k;
      }
    }
  for (TransferVector<uint32_t>* values : {&pixels_, &columns_, &rows_, &kept_}) values->resize(k);
  std::iota(kept_.begin(), kept_.end(), 0u);
  findNeighbors();
}

bool TileLayer::goBehind() {
  ++layer_;
  uint32_t left = 0;
  for (uint32_t k = 0; k < pixels_.size(); ++k) {
    if (counts_[pixels_[k]] <= layer_) continue;
    pixels_[left] = pixels_[k];
    columns_[left] = columns_[k];
    rows_[left] = rows_[k];
    kept_[left] = k;
    ++left;
  }
  for (TransferVector<uint32_t>* values : {&pixels_, &columns_, &rows_, &kept_}) values->resize(left);
  findNeighbors();
  return left > 0;
}

void TileLayer::findNeighbors() {
  const uint32_t stride = tile_.width + 1;
  slots_.assign(size_t{stride} * (tile_.height + 1), 0);
  rowBegins_.resize(tile_.height + 1);
  const auto size = static_cast<uint32_t>(pixels_.size());
  neighbors_.resize(size);
  uint32_t row = 0;
  rowBegins_[0] = 0;
  for (uint32_t k = 0; k < size;) {
    const uint32_t x = columns_[k] - tile_.x0, y = rows_[k] - tile_.y0;
    while (row < y) rowBegins_[++row] = k;
    uint32_t end = k + 1;  // of pixels beside one another
    while (end < size && pixels_[end] == pixels_[end - 1] + 1 && columns_[end] > columns_[k]) ++end;
    const uint32_t* const above = slots_.data() + stride * y + x + 1;
    uint32_t* const own = slots_.data() + stride * (y + 1) + x + 1;
    // The first has none to its west.
    uint32_t north = above[0], northWest = *(above - 1);
    if (north == 0) north = k > rowBegins_[y] ? k : slotAbove(x, y);
    if (northWest == 0) northWest = north;
    neighbors_[k] = {north, north, northWest};
    own[0] = k + 1;
    findInRun(above, own, k, end - k, neighbors_.data() + k);
    k = end;
  }
  while (row < tile_.height) rowBegins_[++row] = size;
}

/// Of a pixel that is the first of its row and has no neighbours.
uint32_t TileLayer::slotAbove(uint32_t x, uint32_t y) const {
  while (y > 0) {
    --y;
    ++x;
    const uint32_t* const begin = columns_.data() + rowBegins_[y];
    const uint32_t* const end = columns_.data() + rowBegins_[y + 1];
    const uint32_t* const behind = std::upper_bound(begin, end, tile_.x0 + x);
    if (behind != begin) return static_cast<uint32_t>(behind - columns_.data());
  }
  return 0;
}

}  // namespace warpscope
