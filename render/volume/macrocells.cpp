// Value ranges of cells, and which of them show something.
// See macrocells.h; the distances are cell_distances.h's.
#include "render/volume/macrocells.h"

#include <algorithm>
#include <cstring>
#include <tuple>

#include "render/base/looked_through.h"
#include "render/base/ranks.h"
#include "render/core/parallel.h"
#include "render/core/simd.h"
#include "render/core/visible_bins.h"
#include "render/volume/cell_distances.h"
#include "render/volume/kept_slices.h"
#include "render/volume/voxel_access.h"

namespace warpscope {
namespace {

/// Whether cells show something, as anyVisibleBetween: CellDistances' marks, a lane each.
IntBatch marksOf(const VisibleBins& bins, const float* lowest, const float* highest) {
  const FloatBatch low = FloatBatch::load_unaligned(lowest), high = FloatBatch::load_unaligned(highest);
  const FloatBatch zero(0.0f), beyond(static_cast<float>(bins.table.bins));
  const FloatBatch slack = selected(low < high, FloatBatch(kRangeSlack) * maxOf(absOf(low), absOf(high)), zero);
  const IntBatch first = bins.table.binOf(low - slack);
  // In front of all bins where a cell has no finite voxel.
  const IntBatch last = bins.table.binOf(high + slack) - truncated(selected(low > high, beyond, zero));
  const IntBatch code = IntBatch::gather(bins.next, first);
  const IntBatch bin = code >> 1;
  const IntBatch visible(CellDistances::kMarked), hidden(CellDistances::kUnmarked);
  const auto isVisible = bin <= last;
  const IntBatch marks = select(isVisible, visible, hidden);
  const auto isUncertain = isVisible & ((code & IntBatch(1)) == IntBatch(1)) & ((bin == first) | (bin == last));
  if (!xsimd::any(isUncertain)) return marks;
  alignas(64) int32_t lanes[kBatchLanes];
  for (int k = 0; k < kBatchLanes; ++k)
    lanes[k] = anyVisibleBetween(bins, lowest[k], highest[k]) ? CellDistances::kMarked : CellDistances::kUnmarked;
  return IntBatch::load_aligned(lanes);
}

/// Cells that are looked at at once, four vectors of them.
constexpr int kCellsAtOnce = 4 * kBatchLanes;

/// Writes CellDistances' marks of `count` cells. Reads up to kCellsAtOnce beyond them.
void markVisible(const VisibleBins& bins, const float* lowest, const float* highest, int count, uint8_t* marks) {
  for (int begin = 0; begin < count; begin += kCellsAtOnce) {
    alignas(64) int32_t wide[kCellsAtOnce];
    uint8_t narrow[kCellsAtOnce];
    for (int i = 0; i < kCellsAtOnce; i += kBatchLanes)
      marksOf(bins, lowest + begin + i, highest + begin + i).store_aligned(wide + i);
    for (int i = 0; i < kCellsAtOnce; ++i) narrow[i] = static_cast<uint8_t>(wide[i]);
    std::memcpy(marks + begin, narrow, static_cast<size_t>(std::min(kCellsAtOnce, count - begin)));
  }
}

/// What a cell of no finite voxel has: the first is greater.
constexpr int kNoLowest = 1, kNoHighest = 0;

/// The least and the greatest of voxels; of those that are finite. Of none the first is greater.
template <class Voxel>
struct VoxelExtremes {
  Voxel lowest = std::numeric_limits<Voxel>::max(), highest = std::numeric_limits<Voxel>::lowest();

  void take(const VoxelExtremes& other) {
    lowest = other.lowest < lowest ? other.lowest : lowest;
    highest = highest < other.highest ? other.highest : highest;
  }
};

/// Of each column of a row of cells, along x: the extremes of all lines that the cells share, as many voxels at once as vectors hold.
template <class Voxel>
class ColumnExtremes {
 public:
  explicit ColumnExtremes(size_t length) : lowest_(length), highest_(length) {}

  void clear() {
    std::ranges::fill(lowest_, VoxelExtremes<Voxel>().lowest);
    std::ranges::fill(highest_, VoxelExtremes<Voxel>().highest);
  }
  void take(const Voxel* line) {
    Voxel* const lowest = lowest_.data();
    Voxel* const highest = highest_.data();
    const size_t length = lowest_.size();  // bytes may be anything, this among it
    for (size_t x = 0; x < length; ++x) {
      const bool counts = isFiniteVoxel(line[x]);
      lowest[x] = counts && line[x] < lowest[x] ? line[x] : lowest[x];
      highest[x] = counts && highest[x] < line[x] ? line[x] : highest[x];
    }
  }
  VoxelExtremes<Voxel> of(int x) const { return {lowest_[static_cast<size_t>(x)], highest_[static_cast<size_t>(x)]}; }

 private:
  std::vector<Voxel> lowest_, highest_;
};

}  // namespace

Macrocells::Macrocells(const Volume& volume, const ValueScale& scale) : type_(volume.type()), scale_(scale) {
  const glm::ivec3 n(volume.dims());
  // Small cells skip more; in large volumes the map over them would take long to make.
  constexpr size_t kLargeVolume = size_t{1} << 27;
  edge_ = volume.voxelCount() < kLargeVolume ? 4 : 8;
  dims_ = (n + edge_ - 1) / edge_;
  visitVoxelType(type_, [&](auto voxelTag) {
    using Voxel = decltype(voxelTag);
    using Number = std::conditional_t<kRounds<Voxel>, double, float>;
    const size_t padded = count() + kCellsAtOnce;
    auto ranges = std::make_shared<Ranges<Number>>();
    ranges->lowest.assign(padded, Number(kNoLowest));
    ranges->highest.assign(padded, Number(kNoHighest));
    const Voxel* voxels = volume.voxelsAs<Voxel>();
    const size_t rows = size_t(dims_.y) * dims_.z;
    const auto [firstRow, endRow] = shareOf(volume.ranks(), rows);
    if (volume.ranks() && firstRow < endRow) {
      const auto first = static_cast<uint32_t>(firstRow / static_cast<size_t>(dims_.y)), last = static_cast<uint32_t>((endRow - 1) / static_cast<size_t>(dims_.y));
      const auto edge = static_cast<uint32_t>(edge_);
      volume.provide({{0, first * edge}, {volume.dims().y, std::min((last + 1) * edge + 1, volume.dims().z)}});
    }
    const size_t rowBytes = volume.sizeBytes() / rows;  // about
    beginLooking((endRow - firstRow) * rowBytes);
    const auto findRow = [&](size_t row, ColumnExtremes<Voxel>& columns) {
      keepWithinMemoryLimit();
      noteLooked(rowBytes);
      const glm::ivec3 first = glm::ivec3(0, static_cast<int>(row % dims_.y), static_cast<int>(row / dims_.y)) * edge_;
      const glm::ivec3 last = glm::min(first + edge_, n - 1);
      columns.clear();
      for (int z = first.z; z <= last.z; ++z)
        for (int y = first.y; y <= last.y; ++y) columns.take(voxels + (size_t(z) * n.y + y) * n.x);
      for (int cx = 0; cx < dims_.x; ++cx) {
        VoxelExtremes<Voxel> ofCell;
        for (int x = cx * edge_, end = std::min(x + edge_, n.x - 1); x <= end; ++x) ofCell.take(columns.of(x));
        if (ofCell.lowest > ofCell.highest) continue;
        const size_t cell = row * dims_.x + cx;
        if constexpr (kRounds<Voxel>) {
          ranges->lowest[cell] = static_cast<double>(ofCell.lowest);
          ranges->highest[cell] = static_cast<double>(ofCell.highest);
        } else {
          ranges->lowest[cell] = interpolant(ofCell.lowest, scale);
          ranges->highest[cell] = interpolant(ofCell.highest, scale);
        }
      }
    };
    const auto findRows = [&](size_t first, size_t end) {
      parallelForRanges(end - first, 4, stopOf(volume.ranks()), [&](size_t begin, size_t last) {
        ColumnExtremes<Voxel> columns(static_cast<size_t>(n.x));
        for (size_t row = first + begin; row < first + last; ++row) findRow(row, columns);
      });
    };
    if (volume.ranks()) {
      findRows(firstRow, endRow);
      for (std::vector<Number>* const numbers : {&ranges->lowest, &ranges->highest}) gatherRows(*numbers, firstRow, endRow, *volume.ranks());
    } else {
      const auto edge = static_cast<uint32_t>(edge_);
      const auto perSlice = static_cast<size_t>(dims_.y);
      forKeptSlices(volume, {.edge = edge, .beyond = 1}, {}, [&](uint32_t first, uint32_t end) { findRows(first / edge * perSlice, (end + edge - 1) / edge * perSlice); });
    }
    if constexpr (kRounds<Voxel>) {
      ofVoxels_ = std::move(ranges);
      findRanges();
    } else {
      ranges_ = std::move(ranges);
    }
  });
}

template <class Number>
void Macrocells::gatherRows(std::vector<Number>& numbers, size_t firstRow, size_t endRow, Ranks& ranks) const {
  const auto begin = numbers.begin();
  const auto ofRow = static_cast<std::ptrdiff_t>(dims_.x);
  std::vector<Number> all(begin + ofRow * static_cast<std::ptrdiff_t>(firstRow), begin + ofRow * static_cast<std::ptrdiff_t>(endRow));
  ranks.allGather(all);
  std::ranges::copy(all, numbers.begin());
}

void Macrocells::findRanges() {
  auto ranges = std::make_shared<Ranges<float>>();
  const size_t padded = ofVoxels_->lowest.size();
  ranges->lowest.assign(padded, float(kNoLowest));
  ranges->highest.assign(padded, float(kNoHighest));
  visitVoxelType(type_, [&](auto voxelTag) {
    using Voxel = decltype(voxelTag);
    constexpr size_t kCells = 1 << 14;
    parallelForRanges(count(), kCells, [&](size_t begin, size_t end) {
      for (size_t cell = begin; cell < end; ++cell) {
        const double lowest = ofVoxels_->lowest[cell], highest = ofVoxels_->highest[cell];
        if (lowest > highest) continue;
        ranges->lowest[cell] = interpolant(static_cast<Voxel>(lowest), scale_);
        ranges->highest[cell] = interpolant(static_cast<Voxel>(highest), scale_);
      }
    });
  });
  ranges_ = std::move(ranges);
}

Macrocells Macrocells::scaledBy(const ValueScale& scale) const {
  Macrocells scaled = *this;
  const auto all = [](const ValueScale& s) { return std::tie(s.origin, s.before, s.first, s.second); };
  if (all(scale) == all(scale_) || !ofVoxels_) return scaled;
  scaled.scale_ = scale;
  scaled.findRanges();
  return scaled;
}

std::vector<uint8_t> Macrocells::emptyDistances(const TransferTable& table) const {
  const std::vector<int32_t> next = nextVisibleBins(table);
  const VisibleBins bins{table.lookup(), next.data()};
  CellDistances distances(dims_);
  parallelForRanges(static_cast<size_t>(dims_.z), 1, [&](size_t begin, size_t end) {
    for (int z = static_cast<int>(begin); z < static_cast<int>(end); ++z) {
      for (int y = 0; y < dims_.y; ++y) {
        const size_t row = (static_cast<size_t>(z) * dims_.y + y) * dims_.x;
        markVisible(bins, lowest() + row, highest() + row, dims_.x, distances.row(y, z));
      }
      distances.spreadInPlane(z);
    }
  });
  return distances.take();
}

}  // namespace warpscope
