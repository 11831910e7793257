// Lines of a slice summed up with their weights, then along x, slice by slice: the same order however many slices are in memory.
// See voxel_means.h.
#include "render/volume/voxel_means.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <type_traits>

#include "render/core/parallel.h"
#include "render/volume/kept_slices.h"

namespace warpscope {
namespace {

/// Of a cell: the mean of the voxels that it has, as far as it is summed up.
struct Sum {
  double values = 0.0, weights = 0.0;
  bool hasOwn = false;  ///< a value whose place is within it
};

/// Rows of means, one at a time. `kHasMissing`: voxels that are not finite are left out.
template <class Voxel, bool kHasMissing>
class RowSums {
 public:
  RowSums(const Volume& volume, const GridMeans& means, double factor)
      : in_(volume.voxelsAs<Voxel>()), dims_(volume.dims()), means_(means), factor_(factor), values_(dims_.x), weights_(kHasMissing ? dims_.x : 0), own_(kHasMissing ? dims_.x : 0) {}

  /// What slices [first, end) of the volume give to a row of the grid's.
  void add(size_t row, uint32_t first, uint32_t end, std::span<Sum> sums) {
    const CellMean& ofY = means_[1][row % means_[1].size()];
    const CellMean& ofZ = means_[2][row / means_[1].size()];
    for (uint32_t z = std::max(first, ofZ.first); z < std::min(end, ofZ.end()); ++z) {
      addLines(ofY, z, ofZ.isOwn(z));
      const double ofSlice = ofZ.weights[z - ofZ.first];
      for (size_t x = 0; x < sums.size(); ++x) addTo(sums[x], means_[0][x], ofSlice);
    }
  }

 private:
  /// The lines of a slice for a row, each with its weight.
  void addLines(const CellMean& ofY, uint32_t z, bool isOwnSlice) {
    std::ranges::fill(values_, 0.0);
    std::ranges::fill(weights_, 0.0);
    std::ranges::fill(own_, false);
    for (uint32_t y = ofY.first; y < ofY.end(); ++y) {
      const Voxel* const line = in_ + (size_t{z} * dims_.y + y) * dims_.x;
      const double weight = ofY.weights[y - ofY.first], factor = weight * factor_;
      if constexpr (kHasMissing) {
        const bool isOwn = isOwnSlice && ofY.isOwn(y);
        for (uint32_t x = 0; x < dims_.x; ++x) {
          const auto value = static_cast<double>(line[x]);
          if (!std::isfinite(value)) continue;
          values_[x] += factor * value;
          weights_[x] += weight;
          own_[x] |= isOwn;
        }
      } else {
        for (uint32_t x = 0; x < dims_.x; ++x) values_[x] += factor * static_cast<double>(line[x]);
      }
    }
  }
  void addTo(Sum& sum, const CellMean& ofX, double ofSlice) const {
    double values = 0.0, weights = 0.0;
    for (uint32_t x = ofX.first; x < ofX.end(); ++x) {
      const double weight = ofX.weights[x - ofX.first];
      values += weight * values_[x];
      if constexpr (kHasMissing) {
        weights += weight * weights_[x];
        sum.hasOwn |= own_[x] && ofX.isOwn(x);
      }
    }
    sum.values += ofSlice * values;
    if constexpr (kHasMissing) sum.weights += ofSlice * weights;
  }

  const Voxel* in_;
  glm::uvec3 dims_;
  const GridMeans& means_;
  double factor_;
  std::vector<double> values_, weights_;
  std::vector<uint8_t> own_;
};

/// Rows that a thread makes at a time.
constexpr size_t kRowsAtATime = 8;

template <class Voxel, bool kHasMissing>
class MeanMaker {
 public:
  using Take = std::function<void(size_t row, std::span<const double> means)>;
  MeanMaker(const Volume& volume, const GridMeans& means, const std::stop_token& stop, const Take& take)
      : volume_(volume), means_(means), stop_(stop), take_(take), columns_(means[0].size()), rowsOfSlice_(means[1].size()), lowest_(volume.statistics().lowest), highest_(volume.statistics().highest) {
    // Sums of the largest numbers are added up smaller; elsewhere nothing is rounded away.
    if (std::max(std::abs(lowest_), std::abs(highest_)) > 0x1p900) smaller_ = 0x1p-64;
  }

  /// Of what is in memory.
  void makeAtOnce(const RowRange& rows) const {
    parallelForRanges(rows.end - rows.first, kRowsAtATime, stop_, [&](size_t begin, size_t end) {
      RowSums<Voxel, kHasMissing> sum(volume_, means_, smaller_);
      std::vector<Sum> sums(columns_);
      for (size_t row = rows.first + begin; row < rows.first + end; ++row) {
        keepWithinMemoryLimit();
        std::ranges::fill(sums, Sum{});
        sum.add(row, 0, volume_.dims().z, sums);
        finish(row, sums);
      }
    });
  }

  /// All slices in their order, `kept` at a time, for those of the grid that they count for: few, since what one is made of overlaps that of the next ones alone.
  void makeBySlices(uint32_t kept) const {
    const std::vector<CellMean>& ofZ = means_[2];
    const glm::uvec3& dims = volume_.dims();
    std::deque<std::vector<Sum>> open;
    size_t firstOpen = 0;
    for (uint32_t at = 0; at < dims.z;) {
      while (firstOpen + open.size() < ofZ.size() && ofZ[firstOpen + open.size()].first <= at) open.emplace_back(rowsOfSlice_ * columns_);
      uint32_t next = at + std::min(kept, dims.z - at);
      if (firstOpen + open.size() < ofZ.size()) next = std::min(next, ofZ[firstOpen + open.size()].first);
      const auto held = volume_.hold({{0, at}, {dims.y, next}}, stop_);
      parallelForRanges(open.size() * rowsOfSlice_, kRowsAtATime, stop_, [&](size_t begin, size_t end) {
        RowSums<Voxel, kHasMissing> sum(volume_, means_, smaller_);
        for (size_t i = begin; i < end; ++i) {
          keepWithinMemoryLimit();
          sum.add(firstOpen * rowsOfSlice_ + i, at, next, rowOf(open[i / rowsOfSlice_], i % rowsOfSlice_));
        }
      });
      at = next;
      for (; !open.empty() && ofZ[firstOpen].end() <= at; ++firstOpen, open.pop_front())
        for (size_t y = 0; y < rowsOfSlice_; ++y) finish(firstOpen * rowsOfSlice_ + y, rowOf(open.front(), y));
    }
  }

 private:
  std::span<Sum> rowOf(std::vector<Sum>& slice, size_t y) const { return std::span(slice).subspan(y * columns_, columns_); }
  void finish(size_t row, std::span<const Sum> sums) const {
    std::vector<double> means(columns_);
    for (size_t x = 0; x < columns_; ++x) {
      const double mean = kHasMissing && sums[x].hasOwn ? sums[x].values / sums[x].weights : sums[x].values;
      // As rounding may leave it, it is beyond the least or the greatest.
      means[x] = kHasMissing && !sums[x].hasOwn ? NAN : std::clamp(mean / smaller_, lowest_, highest_);
    }
    take_(row, means);
  }

  const Volume& volume_;
  const GridMeans& means_;
  const std::stop_token& stop_;
  const Take& take_;
  size_t columns_, rowsOfSlice_;
  double lowest_, highest_;  // of the volume's finite voxels
  double smaller_ = 1.0;
};

}  // namespace

void forRowsOfMeans(const Volume& volume, const GridMeans& means, const RowRange& rows, const std::stop_token& stop, const std::function<void(size_t row, std::span<const double> means)>& take) {
  const auto make = [&]<class Voxel, bool kHasMissing>() {
    const MeanMaker<Voxel, kHasMissing> maker(volume, means, stop, take);
    const uint32_t kept = slicesKept(volume);
    kept == volume.dims().z ? maker.makeAtOnce(rows) : maker.makeBySlices(kept);
  };
  visitVoxelType(volume.type(), [&](auto tag) {
    using Voxel = decltype(tag);
    if constexpr (std::is_floating_point_v<Voxel>)
      if (volume.statistics().nonFinite > 0) return make.template operator()<Voxel, true>();
    make.template operator()<Voxel, false>();
  });
}

}  // namespace warpscope
