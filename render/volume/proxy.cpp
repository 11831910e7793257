// Weighted means, in parallel over slices.
// See proxy.h.
#include "render/volume/proxy.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include "render/base/ranks.h"
#include "render/core/parallel.h"
#include "render/volume/kept_slices.h"

namespace warpscope {
namespace {

/// What of the volume's voxels lies in the copy's, along an axis.
struct Coverage {
  uint32_t first = 0;
  std::vector<float> weights;
};

std::vector<Coverage> coveragesOf(uint32_t fine, uint32_t coarse) {
  std::vector<Coverage> all(coarse);
  const double ratio = static_cast<double>(fine) / coarse;
  for (uint32_t i = 0; i < coarse; ++i) {
    const double begin = i * ratio, end = (i + 1) * ratio;
    all[i].first = static_cast<uint32_t>(begin);
    for (uint32_t voxel = all[i].first; voxel < fine && voxel < end; ++voxel)
      all[i].weights.push_back(static_cast<float>(std::min(end, voxel + 1.0) - std::max(begin, static_cast<double>(voxel))));
  }
  return all;
}

glm::uvec3 dimsFor(const VolumeGeometry& geometry, int longest) {
  const glm::dvec3 extent = glm::dvec3(geometry.dims) * geometry.spacing;
  const double edge = std::max({extent.x, extent.y, extent.z}) / longest;
  glm::uvec3 dims;
  for (int axis = 0; axis < 3; ++axis) dims[axis] = std::clamp(static_cast<uint32_t>(std::lround(extent[axis] / edge)), 1u, geometry.dims[axis]);
  return dims;
}

/// Of the values that a voxel of the copy covers.
struct Sum {
  double values = 0.0, weights = 0.0;
};

}  // namespace

Proxy makeProxy(const Volume& volume, const TransferFunction& function, int longest, const std::stop_token& stop) {
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

  const std::vector<Coverage> alongX = coveragesOf(fine.dims.x, geometry.dims.x), alongY = coveragesOf(fine.dims.y, geometry.dims.y),
                              alongZ = coveragesOf(fine.dims.z, geometry.dims.z);
  const size_t rows = size_t{geometry.dims.z} * geometry.dims.y;
  size_t firstOfShare, endOfShare;
  std::tie(firstOfShare, endOfShare) = shareOf(volume.ranks(), rows);
  if (volume.ranks() && firstOfShare < endOfShare) {
    const Coverage &first = alongZ[firstOfShare / geometry.dims.y], &last = alongZ[(endOfShare - 1) / geometry.dims.y];
    volume.provide({{0, first.first}, {fine.dims.y, last.first + static_cast<uint32_t>(last.weights.size())}}, stop);
  }
  auto voxels = std::make_shared<std::vector<uint8_t>>((endOfShare - firstOfShare) * geometry.dims.x);
  const ProxyScale scale = proxy.scale;
  // Sums of the largest numbers are added up smaller; elsewhere nothing is rounded away.
  const double smaller = std::max(std::abs(statistics.lowest), std::abs(statistics.highest)) > 0x1p900 ? 0x1p-64 : 1.0;
  visitVoxelType(volume.type(), [&](auto tag) {
    using Voxel = decltype(tag);
    const Voxel* const in = volume.voxelsAs<Voxel>();
    const size_t strideY = fine.dims.x, strideZ = strideY * fine.dims.y;
    // What slices [first, end) give to a row.
    const auto add = [&](size_t row, uint32_t first, uint32_t end, Sum* sums) {
      keepWithinMemoryLimit();
      const Coverage& ofY = alongY[row % geometry.dims.y];
      const Coverage& ofZ = alongZ[row / geometry.dims.y];
      for (uint32_t x = 0; x < geometry.dims.x; ++x) {
        const Coverage& ofX = alongX[x];
        Sum sum = sums[x];
        for (size_t k = 0; k < ofZ.weights.size(); ++k) {
          if (ofZ.first + k < first || ofZ.first + k >= end) continue;
          for (size_t j = 0; j < ofY.weights.size(); ++j) {
            const Voxel* const line = in + (ofZ.first + k) * strideZ + (ofY.first + j) * strideY + ofX.first;
            const double ofLine = static_cast<double>(ofZ.weights[k]) * static_cast<double>(ofY.weights[j]);
            for (size_t i = 0; i < ofX.weights.size(); ++i) {
              const double value = static_cast<double>(line[i]);
              if (!std::isfinite(value)) continue;
              const double weight = ofLine * static_cast<double>(ofX.weights[i]);
              sum.values += weight * (value * smaller);
              sum.weights += weight;
            }
          }
        }
        sums[x] = sum;
      }
    };
    const auto finish = [&](size_t row, const Sum* sums) {
      for (uint32_t x = 0; x < geometry.dims.x; ++x) {
        const auto& [values, weights] = sums[x];
        uint8_t code = 0;
        if (weights > 0.0) code = static_cast<uint8_t>(std::lround(std::clamp(scale.codeOf(values / weights / smaller), scale.hasMissing ? 1.0 : 0.0, 255.0)));
        (*voxels)[(row - firstOfShare) * geometry.dims.x + x] = code;
      }
    };
    const auto makeRows = [&](size_t first, size_t end) {
      parallelForRanges(end - first, 1, stop, [&](size_t begin, size_t last) {
        std::vector<Sum> sums(geometry.dims.x);
        for (size_t row = first + begin; row < first + last; ++row) {
          std::ranges::fill(sums, Sum{});
          add(row, 0, fine.dims.z, sums.data());
          finish(row, sums.data());
        }
      });
    };
    const uint32_t kept = slicesKept(volume);
    if (kept == fine.dims.z) return makeRows(firstOfShare, endOfShare);
    // The copy's slices each, of which one may cover more slices than are kept.
    for (uint32_t slice = 0; slice < geometry.dims.z; ++slice) {
      const uint32_t first = alongZ[slice].first, end = first + static_cast<uint32_t>(alongZ[slice].weights.size());
      std::vector<Sum> sums(size_t{geometry.dims.y} * geometry.dims.x);
      const auto forRows = [&](const auto& body) {
        parallelForRanges(geometry.dims.y, 1, stop, [&](size_t begin, size_t last) {
          for (size_t y = begin; y < last; ++y) body(size_t{slice} * geometry.dims.y + y, &sums[y * geometry.dims.x]);
        });
      };
      for (uint32_t at = first; at < end; at += std::min(kept, end - at)) {
        const uint32_t next = at + std::min(kept, end - at);
        const auto held = volume.hold({{0, at}, {fine.dims.y, next}}, stop);
        forRows([&](size_t row, Sum* ofRow) { add(row, at, next, ofRow); });
      }
      forRows(finish);
    }
  });
  if (volume.ranks()) volume.ranks()->allGather(*voxels);
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
