// How voxels become the floats that are interpolated and looked up: as they are where float holds them, else less an origin and times a power of two.
// The same for every voxel of a volume, so that interpolation is that of the voxels' own values.
#pragma once

#include <type_traits>

#include "render/core/arithmetic.h"
#include "render/core/segment_table.h"
#include "render/core/transfer_table.h"
#include "render/volume/volume.h"

namespace warpscope {

/// A value v becomes x = (v * before - origin * before) * first * second. The factors are powers of two, so that float's own rounding is all that is lost:
///  - integers of at most 16 bits and float: nothing (floats beyond 2^126 or all below 2^-60 are scaled, which takes less than 2^-149 of their place);
///  - integers of 32 bits and double: 2^-24 of x, which is a distance from the origin.
/// The origin is the value nearest 0 among those where the transfer function changes, so that what it tells apart is told apart in float as well as can be.
struct ValueScale {
  double origin = 0.0;
  double before = 1.0;  ///< 1, or 1/2 where the difference of two values could overflow
  double first = 1.0;
  double second = 1.0;  ///< beside `first` because one power of two does not reach from the least to the greatest double

  double interpolantOf(double value) const { return (value * before - origin * before) * first * second; }
};

ValueScale valueScaleOf(VoxelType type, const VoxelStatistics& statistics, const TransferFunction& function);

/// Bakes a function of the volume's values into a table of their interpolants, for steps of `step` volume units.
TransferTable bakeTransferTable(const TransferFunction& function, const Volume& volume, const ValueScale& scale, float step,
                                Arithmetic arithmetic = Arithmetic::stable);
SegmentTable bakeSegmentTable(const TransferFunction& function, const Volume& volume, const ValueScale& scale, float step);

/// True for voxel types whose values float cannot hold: on a device they are kept as interpolants.
template <class Voxel>
inline constexpr bool kRounds = sizeof(Voxel) >= 4 && !std::is_same_v<Voxel, float>;

/// A voxel that is an interpolant already: what a device keeps of types that take arithmetic to become one.
struct InterpolantVoxel {
  float value;
};

/// What interpolation works on. Voxels that are not finite stay so.
template <class Voxel>
WARPSCOPE_HD inline float interpolant(Voxel voxel, const ValueScale& scale) {
  if constexpr (sizeof(Voxel) <= 2)
    return static_cast<float>(voxel);
  else if constexpr (std::is_same_v<Voxel, float>)
    return voxel * static_cast<float>(scale.first);
  else if constexpr (std::is_integral_v<Voxel>)
    return static_cast<float>(static_cast<double>(voxel) - scale.origin);
  else
    return static_cast<float>((voxel * scale.before - scale.origin * scale.before) * scale.first * scale.second);
}
WARPSCOPE_HD inline float interpolant(InterpolantVoxel voxel, const ValueScale&) { return voxel.value; }

}  // namespace warpscope
