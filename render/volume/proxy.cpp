// Weighted means, in parallel over rows, and the fit of them.
// See proxy.h.
#include "render/volume/proxy.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <limits>
#include <span>
#include <tuple>

#include "render/base/ranks.h"
#include "render/core/parallel.h"
#include "render/volume/kept_slices.h"
#include "render/volume/linear_fit.h"

namespace warpscope {
namespace {

glm::uvec3 dimsFor(const VolumeGeometry& geometry, int longest) {
  const glm::dvec3 extent = glm::dvec3(geometry.dims) * geometry.spacing;
  const double edge = std::max({extent.x, extent.y, extent.z}) / longest;
  glm::uvec3 dims;
  for (int axis = 0; axis < 3; ++axis) dims[axis] = std::clamp(static_cast<uint32_t>(std::lround(extent[axis] / edge)), 1u, geometry.dims[axis]);
  return dims;
}

/// Of a voxel of the copy: the mean of the values that it stands for, as far as it is summed up.
struct Sum {
  double values = 0.0, weights = 0.0;
  bool hasOwn = false;  ///< a value whose place is within it
};

/// Means along each axis.
struct GridMeans {
  std::vector<CellMean> x, y, z;
};

/// Means of a volume's voxels for its copy, rows of them. `kHasMissing`: voxels that are not finite are left out.
template <class Voxel, bool kHasMissing>
class RowSums {
 public:
  RowSums(const Volume& volume, const GridMeans& means, double factor)
      : in_(volume.voxelsAs<Voxel>()), dims_(volume.dims()), means_(means), factor_(factor), values_(dims_.x), weights_(kHasMissing ? dims_.x : 0), own_(kHasMissing ? dims_.x : 0) {}

  /// What slices [first, end) of the volume give to a row of the copy's.
  void add(size_t row, uint32_t first, uint32_t end, std::span<Sum> sums) {
    const CellMean& ofY = means_.y[row % means_.y.size()];
    const CellMean& ofZ = means_.z[row / means_.y.size()];
    for (uint32_t z = std::max(first, ofZ.first); z < std::min(end, ofZ.end()); ++z) {
      addLines(ofY, z, ofZ.isOwn(z));
      const double ofSlice = ofZ.weights[z - ofZ.first];
      for (size_t x = 0; x < sums.size(); ++x) addTo(sums[x], means_.x[x], ofSlice);
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

}  // namespace

Proxy makeProxy(const Volume& volume, const TransferFunction& function, int longest, CopyFilter filter, const std::stop_token& stop) {
  const VolumeGeometry& fine = volume.geometry();
  VolumeGeometry geometry = fine;
  geometry.dims = dimsFor(fine, longest);
  geometry.unitEdge = fine.unit();
  geometry.spacing = fine.spacing * glm::dvec3(fine.dims) / glm::dvec3(geometry.dims);
  const glm::dvec3 shift = 0.5 * (geometry.spacing - fine.spacing);
  geometry.origin = fine.origin + fine.direction * shift;

  const VoxelStatistics& statistics = volume.statistics();
  Proxy proxy;
  proxy.function = function;
  proxy.scale.hasMissing = statistics.nonFinite > 0;
  proxy.scale.lowest = statistics.rangeLower;
  const double codes = proxy.scale.hasMissing ? 254.0 : 255.0;
  const double halfRange = 0.5 * statistics.rangeUpper - 0.5 * statistics.rangeLower;
  proxy.scale.perCode = halfRange > 0.0 ? std::max(2.0 * (halfRange / codes), 2.0 * std::numeric_limits<double>::denorm_min()) : 1.0;

  std::vector<LinearFit> fits;
  GridMeans means;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<CellMean>& along = axis == 0 ? means.x : axis == 1 ? means.y : means.z;
    if (filter == CopyFilter::nearest)
      along = fits.emplace_back(fine.dims[axis], geometry.dims[axis]).means();
    else
      along = boxMeans(fine.dims[axis], geometry.dims[axis]);
  }
  const size_t columns = geometry.dims.x, rowsOfSlice = geometry.dims.y;
  size_t firstOfShare, endOfShare;
  std::tie(firstOfShare, endOfShare) = shareOf(volume.ranks(), geometry.dims.z * rowsOfSlice);
  if (volume.ranks() && firstOfShare < endOfShare)
    volume.provide({{0, means.z[firstOfShare / rowsOfSlice].first}, {fine.dims.y, means.z[(endOfShare - 1) / rowsOfSlice].end()}}, stop);
  auto voxels = std::make_shared<std::vector<uint8_t>>((endOfShare - firstOfShare) * columns);
  std::vector<float> unrounded(filter == CopyFilter::nearest ? voxels->size() : 0);  // codes; NaN: missing
  const ProxyScale scale = proxy.scale;
  // Sums of the largest numbers are added up smaller; elsewhere nothing is rounded away.
  const double smaller = std::max(std::abs(statistics.lowest), std::abs(statistics.highest)) > 0x1p900 ? 0x1p-64 : 1.0;
  const auto rounded = [&](float code) {
    return std::isnan(code) ? uint8_t{0} : static_cast<uint8_t>(std::lround(std::clamp(code, scale.hasMissing ? 1.0f : 0.0f, 255.0f)));
  };
  const auto finish = [&](size_t row, std::span<const Sum> sums) {
    for (size_t x = 0; x < columns; ++x) {
      const auto& [values, weights, hasOwn] = sums[x];
      const double mean = scale.hasMissing ? values / weights : values;
      const auto code = static_cast<float>(scale.hasMissing && !hasOwn ? NAN : scale.codeOf(mean / smaller));
      const size_t at = (row - firstOfShare) * columns + x;
      if (filter == CopyFilter::nearest)
        unrounded[at] = code;
      else
        (*voxels)[at] = rounded(code);
    }
  };
  const auto sumUp = [&]<class Voxel, bool kHasMissing>() {
    using Rows = RowSums<Voxel, kHasMissing>;
    const uint32_t kept = slicesKept(volume);
    if (kept == fine.dims.z) {
      parallelForRanges(endOfShare - firstOfShare, 1, stop, [&](size_t begin, size_t end) {
        Rows rows(volume, means, smaller);
        std::vector<Sum> sums(columns);
        for (size_t row = firstOfShare + begin; row < firstOfShare + end; ++row) {
          keepWithinMemoryLimit();
          std::ranges::fill(sums, Sum{});
          rows.add(row, 0, fine.dims.z, sums);
          finish(row, sums);
        }
      });
      return;
    }
    // All slices in their order, as many as are kept at a time, for those of the copy that they count for: few, since what one is made of overlaps that of the next ones alone.
    std::deque<std::vector<Sum>> open;
    uint32_t firstOpen = 0;
    for (uint32_t at = 0; at < fine.dims.z;) {
      while (firstOpen + open.size() < geometry.dims.z && means.z[firstOpen + open.size()].first <= at) open.emplace_back(rowsOfSlice * columns);
      uint32_t next = at + std::min(kept, fine.dims.z - at);
      if (firstOpen + open.size() < geometry.dims.z) next = std::min(next, means.z[firstOpen + open.size()].first);
      const auto held = volume.hold({{0, at}, {fine.dims.y, next}}, stop);
      parallelForRanges(open.size() * rowsOfSlice, 1, stop, [&](size_t begin, size_t end) {
        Rows rows(volume, means, smaller);
        for (size_t i = begin; i < end; ++i) {
          keepWithinMemoryLimit();
          rows.add(firstOpen * rowsOfSlice + i, at, next, std::span(open[i / rowsOfSlice]).subspan(i % rowsOfSlice * columns, columns));
        }
      });
      at = next;
      for (; !open.empty() && means.z[firstOpen].end() <= at; ++firstOpen, open.pop_front())
        for (size_t y = 0; y < rowsOfSlice; ++y) finish(firstOpen * rowsOfSlice + y, std::span(open.front()).subspan(y * columns, columns));
    }
  };
  visitVoxelType(volume.type(), [&](auto tag) {
    using Voxel = decltype(tag);
    if constexpr (std::is_floating_point_v<Voxel>)
      if (scale.hasMissing) return sumUp.template operator()<Voxel, true>();
    sumUp.template operator()<Voxel, false>();
  });
  if (filter == CopyFilter::nearest) {
    if (volume.ranks()) volume.ranks()->allGather(unrounded);
    solveGrid(unrounded, fits[0], fits[1], fits[2]);
    voxels->resize(unrounded.size());
    std::ranges::transform(unrounded, voxels->begin(), rounded);
  } else if (volume.ranks()) {
    volume.ranks()->allGather(*voxels);
  }
  const void* const data = voxels->data();
  proxy.volume = std::make_shared<const Volume>(volume.name(), VoxelType::uint8, geometry, std::move(voxels), data, stop);
  return proxy;
}

TransferFunction functionOfCodes(const Proxy& proxy) {
  const TransferFunction& function = proxy.function;
  const ProxyScale& scale = proxy.scale;
  TransferFunction ofCodes = function;
  for (TransferPoint& point : ofCodes.points) point.value = scale.codeOf(point.value);
  if (!scale.hasMissing) return ofCodes;
  // Nothing below the first code that is a value: interpolation towards what is missing fades out.
  std::vector<TransferPoint> points{{0.0, function.at(scale.lowest), 0.0f}, {0.5, function.at(scale.lowest), 0.0f}};
  const glm::vec4 first = ofCodes.at(0.5);
  points.push_back({0.5, glm::vec3(first), first.a});
  for (const TransferPoint& point : ofCodes.points)
    if (point.value > 0.5) points.push_back(point);
  ofCodes.points = std::move(points);
  return ofCodes;
}

}  // namespace warpscope
