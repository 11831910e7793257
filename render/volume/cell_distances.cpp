// Vectors of bytes over rows.
// See cell_distances.h. Every value is at all times a bound from above of a distance: what is read after it was
// improved is right as well.
#include "render/volume/cell_distances.h"

#include <algorithm>
#include <cstring>

#include "render/core/simd.h"

namespace warpscope {
namespace {

using ByteBatch = xsimd::batch<uint8_t>;
constexpr size_t kBytes = ByteBatch::size;

ByteBatch load(const uint8_t* at) { return ByteBatch::load_unaligned(at); }
/// One step farther, at most 255.
ByteBatch farther(const ByteBatch& distance, int steps) {
  return xsimd::sadd(distance, ByteBatch(static_cast<uint8_t>(steps)));
}
/// The nearest of each cell and its two neighbours along the row.
ByteBatch nearestOfThree(const uint8_t* at) { return min(min(load(at - 1), load(at)), load(at + 1)); }

/// From one row to its neighbour.
void spreadToRow(const uint8_t* from, uint8_t* to, size_t width) {
  for (size_t x = 0; x < width; x += kBytes)
    min(load(to + x), farther(nearestOfThree(from + x), 1)).store_unaligned(to + x);
}

}  // namespace

CellDistances::CellDistances(const glm::ivec3& dims)
    : dims_(dims),
      width_((static_cast<size_t>(dims.x) + kBytes - 1) / kBytes * kBytes),
      stride_(width_ + kMargin),
      cells_(kMargin + stride_ * dims.y * dims.z, kUnmarked) {}

void CellDistances::spreadInPlane(int z) {
  constexpr int kFarthest = 128;  // with all smaller powers of two 255
  std::vector<uint8_t> line(kFarthest + width_ + kFarthest, kUnmarked);
  uint8_t* const cells = line.data() + kFarthest;
  for (int y = 0; y < dims_.y; ++y) {
    uint8_t* const here = row(y, z);
    std::memcpy(cells, here, width_);
    for (int steps = 1; steps < dims_.x && steps <= kFarthest; steps *= 2)
      for (size_t x = 0; x < width_; x += kBytes) {
        const ByteBatch nearest = min(load(cells + x - steps), load(cells + x + steps));
        min(load(cells + x), farther(nearest, steps)).store_unaligned(cells + x);
      }
    std::memcpy(here, cells, width_);
    if (y > 0) spreadToRow(row(y - 1, z), here, width_);
  }
  for (int y = dims_.y - 1; y-- > 0;) spreadToRow(row(y + 1, z), row(y, z), width_);
}

void CellDistances::spreadFromPlane(int from, int to) {
  for (size_t x = 0; x < width_; x += kBytes) {
    ByteBatch before(kUnmarked), here = nearestOfThree(row(0, from) + x);
    for (int y = 0; y < dims_.y; ++y) {
      const ByteBatch behind = y + 1 < dims_.y ? nearestOfThree(row(y + 1, from) + x) : ByteBatch(kUnmarked);
      uint8_t* const cell = row(y, to) + x;
      min(load(cell), farther(min(min(before, here), behind), 1)).store_unaligned(cell);
      before = here;
      here = behind;
    }
  }
}

std::vector<uint8_t> CellDistances::take() {
  for (int z = 1; z < dims_.z; ++z) spreadFromPlane(z - 1, z);
  std::vector<uint8_t> distances(static_cast<size_t>(dims_.x) * dims_.y * dims_.z);
  for (int z = dims_.z; z-- > 0;) {
    if (z + 1 < dims_.z) spreadFromPlane(z + 1, z);
    for (int y = 0; y < dims_.y; ++y)
      std::memcpy(distances.data() + (static_cast<size_t>(z) * dims_.y + y) * dims_.x, row(y, z),
                  static_cast<size_t>(dims_.x));
  }
  return distances;
}

}  // namespace warpscope
