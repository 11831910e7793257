// Which origin and which power of two.
// See value_scale.h.
#include "render/volume/value_scale.h"

#include <algorithm>
#include <cmath>

#include "render/core/textbook_table.h"

namespace warpscope {
namespace {

/// Exponent of the power of two that brings the exponent of `largest` into that range; 0 where it is there.
int exponentFor(double largest, int least, int most) {
  if (!(largest > 0.0)) return 0;
  const int exponent = std::ilogb(largest);
  return std::clamp(exponent, least, most) - exponent;
}

TransferFunction functionOfInterpolants(TransferFunction function, const Volume& volume, const ValueScale& scale) {
  const bool rounds = visitVoxelType(volume.type(), [](auto voxel) { return kRounds<decltype(voxel)>; });
  constexpr double kLargest = 0x1p126;
  for (TransferPoint& point : function.points) {
    point.value = std::clamp(scale.interpolantOf(point.value), -kLargest, kLargest);
    if (rounds) point.value = static_cast<double>(static_cast<float>(point.value));  // as voxels of that value are
  }
  return function;
}

TransferDomain domainOf(const Volume& volume, const ValueScale& scale) {
  const VoxelStatistics& statistics = volume.statistics();
  TransferDomain domain;
  domain.lower = static_cast<float>(scale.interpolantOf(statistics.rangeLower));
  domain.upper = static_cast<float>(scale.interpolantOf(statistics.rangeUpper));
  domain.isWhole = sizeBytes(volume.type()) <= 2;
  return domain;
}

}  // namespace

ValueScale valueScaleOf(VoxelType type, const VoxelStatistics& statistics, const TransferFunction& function) {
  ValueScale scale;
  if (sizeBytes(type) <= 2) return scale;
  const double lower = statistics.rangeLower, upper = statistics.rangeUpper;
  if (type == VoxelType::float32) {
    // Differences of two, and sums of eight, stay below the greatest float; one factor that is a float is enough.
    scale.first = std::ldexp(1.0, std::min(120, exponentFor(std::max(std::abs(lower), std::abs(upper)), -60, 123)));
    return scale;
  }
  if (!function.points.empty()) {
    const double first = std::clamp(function.points.front().value, lower, upper);
    const double last = std::clamp(function.points.back().value, lower, upper);
    scale.origin = std::clamp(0.0, first, last);
  }
  if (type != VoxelType::float64) return scale;
  if (!std::isfinite(upper - lower)) scale.before = 0.5;
  const double largest = std::max(std::abs(scale.interpolantOf(lower)), std::abs(scale.interpolantOf(upper)));
  const int exponent = exponentFor(largest, -60, 100);
  scale.first = std::ldexp(1.0, exponent / 2);
  scale.second = std::ldexp(1.0, exponent - exponent / 2);
  return scale;
}

TransferTable bakeTransferTable(const TransferFunction& function, const Volume& volume, const ValueScale& scale, float step,
                                Arithmetic arithmetic) {
  const TransferFunction ofInterpolants = functionOfInterpolants(function, volume, scale);
  const TransferDomain domain = domainOf(volume, scale);
  return arithmetic == Arithmetic::textbook ? bakeTextbookTable(ofInterpolants, domain, step)
                                            : bakeTransferTable(ofInterpolants, domain, step);
}

SegmentTable bakeSegmentTable(const TransferFunction& function, const Volume& volume, const ValueScale& scale, float step) {
  return bakeSegmentTable(functionOfInterpolants(function, volume, scale), domainOf(volume, scale), step);
}

}  // namespace warpscope
