// Reading a volume's value at any place: conversion of voxels and trilinear interpolation, for host and device.
// Voxel coordinates: voxel (i,j,k) has its centre at (i,j,k); beyond the outermost centres values are constant.
// Non-finite voxels have no weight: the others share it, and where half of it or more is missing there is no value.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <type_traits>

#include "render/core/numeric.h"
#include "render/volume/volume.h"

namespace warpscope {

template <class Voxel>
WARPSCOPE_HD inline bool isFiniteVoxel(Voxel voxel) {
  if constexpr (std::is_floating_point_v<Voxel>)
    return voxel - voxel == Voxel(0);
  else
    return true;
}

/// How values become fractions of the volume's range: (value - lower) * inverseExtent. inverseExtent is 0 for a range without extent, or
/// with one so small that its reciprocal overflows.
struct ValueScale {
  double lower = 0.0;
  double inverseExtent = 0.0;
};

inline ValueScale valueScaleOf(const VoxelStatistics& statistics) {
  // Halves, because the extent of a double volume may overflow.
  const double half = 0.5 * statistics.rangeUpper - 0.5 * statistics.rangeLower;
  const double inverse = 0.5 / half;
  return {statistics.rangeLower, half > 0.0 && std::isfinite(2.0 * inverse) ? inverse : 0.0};
}

/// True for voxel types whose values float cannot hold: they become fractions before interpolation instead of after it.
template <class Voxel>
inline constexpr bool kNormalizeFirst = sizeof(Voxel) >= 4;

template <class Voxel>
WARPSCOPE_HD inline float unitFromVoxel(Voxel voxel, const ValueScale& scale) {
  if constexpr (kNormalizeFirst<Voxel>)
    // Halves, because the difference of two doubles may overflow.
    return static_cast<float>((0.5 * static_cast<double>(voxel) - 0.5 * scale.lower) * (2.0 * scale.inverseExtent));
  else
    return (static_cast<float>(voxel) - static_cast<float>(scale.lower)) * static_cast<float>(scale.inverseExtent);
}

/// What interpolation works on: the voxel itself where float holds it exactly, else its fraction of the range.
template <class Voxel>
WARPSCOPE_HD inline float interpolant(Voxel voxel, const ValueScale& scale) {
  if constexpr (kNormalizeFirst<Voxel>)
    return unitFromVoxel(voxel, scale);
  else
    return static_cast<float>(voxel);
}

/// A voxel that is a fraction of the volume's range already: what a device keeps of types whose values float cannot hold.
struct UnitVoxel {
  float unit;
};
WARPSCOPE_HD inline float interpolant(UnitVoxel voxel, const ValueScale&) { return voxel.unit; }

/// Float is float or a vector of floats.
template <class Voxel, class Float>
WARPSCOPE_HD inline Float unitFromInterpolant(const Float& value, const ValueScale& scale) {
  if constexpr (kNormalizeFirst<Voxel>)
    return value;
  else
    return (value - Float(static_cast<float>(scale.lower))) * Float(static_cast<float>(scale.inverseExtent));
}

/// Where a coordinate lies along an axis of `voxels`: the lower of the two voxels to blend (0 where there is but one), and the upper one's
/// weight. Float is float or a vector of floats, Int the matching integer.
template <class Float, class Int>
WARPSCOPE_HD inline void axisCell(const Float& coordinate, int voxels, Int& index, Float& weight) {
  const Float clamped = minOf(maxOf(coordinate, Float(0.0f)), Float(static_cast<float>(voxels - 1)));
  index = minOf(truncated(clamped), Int(voxels > 1 ? voxels - 2 : 0));
  weight = clamped - converted(index);
}

template <class Float>
WARPSCOPE_HD inline Float lerp(const Float& a, const Float& b, const Float& weight) {
  return a + weight * (b - a);
}

/// The eight values around a place, x fastest, blended.
template <class Float>
WARPSCOPE_HD inline Float trilinear(const Float (&c)[8], const Float& wx, const Float& wy, const Float& wz) {
  const Float low = lerp(lerp(c[0], c[1], wx), lerp(c[2], c[3], wx), wy);
  const Float high = lerp(lerp(c[4], c[5], wx), lerp(c[6], c[7], wx), wy);
  return lerp(low, high, wz);
}

/// trilinear, bit for bit, where all corners are finite; else those that are not have no weight. NaN if they carry half the weight or more.
WARPSCOPE_HD inline float trilinearOfFinite(const float (&c)[8], float wx, float wy, float wz) {
  bool whole = true;
  for (int i = 0; i < 8; ++i) whole = whole && isFiniteVoxel(c[i]);
  if (whole) return trilinear(c, wx, wy, wz);
  float sum = 0.0f;
  float weights = 0.0f;
  for (int i = 0; i < 8; ++i) {
    const float weight = (i & 1 ? wx : 1.0f - wx) * (i & 2 ? wy : 1.0f - wy) * (i & 4 ? wz : 1.0f - wz);
    if (!isFiniteVoxel(c[i])) continue;
    sum += weight * c[i];
    weights += weight;
  }
  return weights > 0.5f ? sum / weights : NAN;
}

}  // namespace warpscope
