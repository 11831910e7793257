// Means of what each voxel has or has a part in, as codes, and the fit of them.
// See proxy.h.
#include "render/volume/proxy.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <tuple>
#include <vector>

#include "render/base/ranks.h"
#include "render/volume/linear_fit.h"
#include "render/volume/voxel_means.h"

namespace warpscope {
namespace {

glm::uvec3 dimsFor(const VolumeGeometry& geometry, int longest) {
  const glm::dvec3 extent = glm::dvec3(geometry.dims) * geometry.spacing;
  const double edge = std::max({extent.x, extent.y, extent.z}) / longest;
  glm::uvec3 dims;
  for (int axis = 0; axis < 3; ++axis) dims[axis] = std::clamp(static_cast<uint32_t>(std::lround(extent[axis] / edge)), 1u, geometry.dims[axis]);
  return dims;
}

ProxyScale scaleFor(const VoxelStatistics& statistics, bool isExact) {
  ProxyScale scale;
  scale.hasMissing = statistics.nonFinite > 0;
  scale.lowest = statistics.rangeLower;
  // Whole numbers that are few enough stay what they are.
  if (isExact) {
    scale.lowest = statistics.lowest;
    return scale;
  }
  const double codes = scale.hasMissing ? 254.0 : 255.0;
  const double halfRange = 0.5 * statistics.rangeUpper - 0.5 * statistics.rangeLower;
  scale.perCode = halfRange > 0.0 ? std::max(2.0 * (halfRange / codes), 2.0 * std::numeric_limits<double>::denorm_min()) : 1.0;
  return scale;
}

}  // namespace

Proxy makeProxy(const Volume& volume, const TransferFunction& function, int longest, CopyFilter filter, const std::stop_token& stop) {
  const VolumeGeometry& fine = volume.geometry();
  VolumeGeometry geometry = fine;
  geometry.dims = dimsFor(fine, longest);
  geometry.unitEdge = fine.unit();
  geometry.spacing = fine.spacing * glm::dvec3(fine.dims) / glm::dvec3(geometry.dims);
  const glm::dvec3 shift = 0.5 * (geometry.spacing - fine.spacing);
  geometry.origin = fine.origin + fine.direction * shift;

  Proxy proxy;
  proxy.function = function;
  const bool hasAllVoxels = geometry.dims == fine.dims, isOfWhole = volume.type() != VoxelType::float32 && volume.type() != VoxelType::float64;
  proxy.isExact = hasAllVoxels && isOfWhole && volume.statistics().nonFinite == 0 && volume.statistics().highest - volume.statistics().lowest <= 255.0;
  const ProxyScale scale = proxy.scale = scaleFor(volume.statistics(), proxy.isExact);

  // What has all of the volume's voxels is nearest as it is.
  const bool isFitted = filter == CopyFilter::leastSquares && !hasAllVoxels;
  std::vector<LinearFit> fits;
  GridMeans means;
  for (int axis = 0; axis < 3; ++axis) {
    if (isFitted) fits.emplace_back(fine.dims[axis], geometry.dims[axis]);
    means[static_cast<size_t>(axis)] = isFitted ? fits.back().means() : boxMeans(fine.dims[axis], geometry.dims[axis]);
  }
  const size_t columns = geometry.dims.x, rowsOfSlice = geometry.dims.y;
  RowRange share;
  std::tie(share.first, share.end) = shareOf(volume.ranks(), geometry.dims.z * rowsOfSlice);
  if (volume.ranks() && share.first < share.end)
    volume.provide({{0, means[2][share.first / rowsOfSlice].first}, {fine.dims.y, means[2][(share.end - 1) / rowsOfSlice].end()}}, stop);
  const double firstCode = scale.hasMissing ? 1.0 : 0.0;
  const auto rounded = [&](double code) { return std::isnan(code) ? uint8_t{0} : static_cast<uint8_t>(std::lround(std::clamp(code, firstCode, 255.0))); };
  // Codes of means, which lie within those that there are.
  const auto makeMeans = [&](auto& ofShare, const auto& encode) {
    ofShare.resize((share.end - share.first) * columns);
    forRowsOfMeans(volume, means, share, stop, [&](size_t row, std::span<const double> ofRow) {
      std::ranges::transform(ofRow, &ofShare[(row - share.first) * columns],
                             [&](double mean) { return encode(std::isnan(mean) ? NAN : std::clamp(scale.codeOf(mean), firstCode, 255.0)); });
    });
    if (volume.ranks()) volume.ranks()->allGather(ofShare);
  };
  auto voxels = std::make_shared<std::vector<uint8_t>>();
  if (isFitted) {
    std::vector<float> codes;  // NaN: missing
    makeMeans(codes, [](double code) { return static_cast<float>(code); });
    solveGrid(codes, fits, stop);
    voxels->resize(codes.size());
    std::ranges::transform(codes, voxels->begin(), [&](float code) { return rounded(static_cast<double>(code)); });
  } else {
    makeMeans(*voxels, rounded);
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
