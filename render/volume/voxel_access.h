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
  // The same line through the range, for values that float holds: value * factor + offset.
  float factor = 0.0f;
  float offset = 0.0f;
};

inline ValueScale valueScaleOf(const VoxelStatistics& statistics) {
  // Halves, because the extent of a double volume may overflow.
  const double half = 0.5 * statistics.rangeUpper - 0.5 * statistics.rangeLower;
  const double inverse = 0.5 / half;
  const double inverseExtent = half > 0.0 && std::isfinite(2.0 * inverse) ? inverse : 0.0;
  return {statistics.rangeLower, inverseExtent, static_cast<float>(inverseExtent),
          static_cast<float>(-statistics.rangeLower * inverseExtent)};
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
    return mulAdd(static_cast<float>(voxel), scale.factor, scale.offset);
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
    return mulAdd(value, Float(scale.factor), Float(scale.offset));
}

/// The ends of an axis.
struct AxisEnds {
  float lastVoxel;  ///< as a coordinate
  int lastCell;     ///< cells lie between voxels; 0 where there is but one voxel
};
WARPSCOPE_HD inline AxisEnds axisEndsOf(int voxels) { return {static_cast<float>(voxels - 1), voxels > 1 ? voxels - 2 : 0}; }

/// Where a coordinate lies along an axis: the cell, that is the lower of the two voxels to blend, and the upper one's weight.
/// Float is float or a vector of floats, Int the matching integer. Axes have fewer than 2^23 voxels.
template <class Float, class Int>
WARPSCOPE_HD inline void axisCell(const Float& coordinate, const AxisEnds& ends, Int& index, Float& weight) {
  const Float clamped = minOf(maxOf(coordinate, Float(0.0f)), Float(ends.lastVoxel));
  index = truncatedTo(clamped, Int(ends.lastCell));
  weight = clamped - converted(index);
}

template <class Float>
WARPSCOPE_HD inline Float lerp(const Float& a, const Float& b, const Float& weight) {
  return mulAdd(weight, b - a, a);
}

/// The eight values around a place, x fastest, blended.
template <class Float>
WARPSCOPE_HD inline Float trilinear(const Float (&c)[8], const Float& wx, const Float& wy, const Float& wz) {
  const Float low = lerp(lerp(c[0], c[1], wx), lerp(c[2], c[3], wx), wy);
  const Float high = lerp(lerp(c[4], c[5], wx), lerp(c[6], c[7], wx), wy);
  return lerp(low, high, wz);
}

/// The eight voxels that are blended around a place, x fastest: for memory that is plentiful and wants few wide loads.
template <class Voxel>
struct alignas(sizeof(Voxel) * 8 < 16 ? sizeof(Voxel) * 8 : 16) VoxelCell {
  Voxel corners[8];
};

/// Along x, the values at a cell's lower corners and how much each rises towards its upper neighbour.
struct CellPairs {
  float lower[4];
  float rise[4];
};

/// A cell's corners as interpolation wants them: the differences that lerp() takes, taken once. A device has no instruction that turns a byte
/// inside a word into a float, but one that puts it behind the exponent of 2^23: what is too much is taken away exactly.
template <class Voxel>
WARPSCOPE_HD inline CellPairs pairsOf(const VoxelCell<Voxel>& cell, const ValueScale& scale) {
  CellPairs pairs;
#if defined(__CUDA_ARCH__)
  constexpr bool byBytes = std::is_integral_v<Voxel> && sizeof(Voxel) <= 2;
#else
  constexpr bool byBytes = false;
#endif
  if constexpr (byBytes) {
#if defined(__CUDA_ARCH__)
    constexpr bool isSigned = std::is_signed_v<Voxel>;
    constexpr uint32_t half = isSigned ? 1u << (8 * sizeof(Voxel) - 1) : 0u;  // signed ones are moved up, so that none is below 0
    constexpr uint32_t halves = sizeof(Voxel) == 1 ? half * 0x01010101u : half * 0x00010001u;
    constexpr uint32_t kWords = 2 * sizeof(Voxel);
    struct alignas(alignof(VoxelCell<Voxel>)) Words {
      uint32_t word[kWords];
    };
    const Words words = reinterpret_cast<const Words&>(cell);  // one wide load
    float raised[8];
    for (uint32_t i = 0; i < 8; ++i) {
      // Which bytes go where: the voxel's own lowest, then zeros, then 0x4b, the exponent.
      const uint32_t selector = sizeof(Voxel) == 1 ? 0x7440u + i % 4 : i % 2 == 0 ? 0x7410u : 0x7432u;
      raised[i] = __uint_as_float(__byte_perm(words.word[i * kWords / 8] ^ halves, 0x4b000000u, selector));
    }
    for (int i = 0; i < 4; ++i) {
      pairs.lower[i] = raised[2 * i] - (8388608.0f + static_cast<float>(half));
      pairs.rise[i] = raised[2 * i + 1] - raised[2 * i];
    }
#endif
  } else {
    for (int i = 0; i < 4; ++i) {
      pairs.lower[i] = interpolant(cell.corners[2 * i], scale);
      pairs.rise[i] = interpolant(cell.corners[2 * i + 1], scale) - pairs.lower[i];
    }
  }
  return pairs;
}

/// trilinear() of a cell, bit for bit.
WARPSCOPE_HD inline float trilinear(const CellPairs& cell, float wx, float wy, float wz) {
  float edge[4];
  for (int i = 0; i < 4; ++i) edge[i] = mulAdd(wx, cell.rise[i], cell.lower[i]);
  return lerp(lerp(edge[0], edge[1], wy), lerp(edge[2], edge[3], wy), wz);
}

/// Gathers a cell; an axis with a single voxel takes it twice.
template <class Voxel>
WARPSCOPE_HD inline VoxelCell<Voxel> voxelCellAt(const Voxel* voxels, const glm::ivec3& dims, const glm::ivec3& cell) {
  VoxelCell<Voxel> gathered;
  for (int i = 0; i < 8; ++i) {
    const size_t x = cell.x + (i & 1 && dims.x > 1 ? 1 : 0), y = cell.y + (i & 2 && dims.y > 1 ? 1 : 0), z = cell.z + (i & 4 && dims.z > 1 ? 1 : 0);
    gathered.corners[i] = voxels[(z * dims.y + y) * dims.x + x];
  }
  return gathered;
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
