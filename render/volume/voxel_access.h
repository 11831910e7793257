// Reading a volume's value at any place: trilinear interpolation, for host and device. What becomes of a voxel first is in value_scale.h.
// Voxel coordinates: voxel (i,j,k) has its centre at (i,j,k); beyond the outermost centres values are constant.
// Non-finite voxels have no weight: the others share it, and where half of it or more is missing there is no value.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <type_traits>

#include "render/core/numeric.h"
#include "render/volume/value_scale.h"

namespace warpscope {

template <class Voxel>
WARPSCOPE_HD inline bool isFiniteVoxel(Voxel voxel) {
  if constexpr (std::is_floating_point_v<Voxel>)
    return voxel - voxel == Voxel(0);
  else
    return true;
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

/// What trilinear() is off by, relative to the largest value's magnitude: along each of three axes two roundings of a
/// difference that may be twice as large, weighted by at most 1, and one of the result. Equal values are blended
/// exactly.
inline constexpr double kTrilinearError = 9.001 * 0x1p-24;

/// The eight values around a place, x fastest, blended: within kTrilinearError.
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

/// Whether voxels are read byte by byte: a device has no instruction that turns a byte inside a word into a float, but one that puts it behind the
/// exponent of 2^23. What is too much then is the same for all of them, and differences are exact.
template <class Voxel>
#if defined(__CUDA_ARCH__)
inline constexpr bool kIsRaised = std::is_integral_v<Voxel> && sizeof(Voxel) <= 2;
#else
inline constexpr bool kIsRaised = false;
#endif

/// What raisedCorners() add to a voxel.
template <class Voxel>
inline constexpr float kRaise = 8388608.0f + (std::is_signed_v<Voxel> ? static_cast<float>(1u << (8 * sizeof(Voxel) - 1)) : 0.0f);

/// A cell's corners, each more than it is by kRaise.
template <class Voxel>
WARPSCOPE_HD inline void raisedCorners(const VoxelCell<Voxel>& cell, float (&raised)[8]) {
#if defined(__CUDA_ARCH__)
  constexpr uint32_t half = std::is_signed_v<Voxel> ? 1u << (8 * sizeof(Voxel) - 1) : 0u;  // signed ones are moved up, so that none is below 0
  constexpr uint32_t halves = sizeof(Voxel) == 1 ? half * 0x01010101u : half * 0x00010001u;
  constexpr uint32_t kWords = 2 * sizeof(Voxel);
  struct alignas(alignof(VoxelCell<Voxel>)) Words {
    uint32_t word[kWords];
  };
  const Words words = reinterpret_cast<const Words&>(cell);  // one wide load
  for (uint32_t i = 0; i < 8; ++i) {
    // Which bytes go where: the voxel's own lowest, then zeros, then 0x4b, the exponent.
    const uint32_t selector = sizeof(Voxel) == 1 ? 0x7440u + i % 4 : i % 2 == 0 ? 0x7410u : 0x7432u;
    raised[i] = __uint_as_float(__byte_perm(words.word[i * kWords / 8] ^ halves, 0x4b000000u, selector));
  }
#else
  for (int i = 0; i < 8; ++i) raised[i] = static_cast<float>(cell.corners[i]) + kRaise<Voxel>;
#endif
}

/// Along x, the values at a cell's lower corners and how much each rises towards its upper neighbour.
struct CellPairs {
  float lower[4];
  float rise[4];
};

/// A cell's corners as interpolation wants them: the differences that lerp() takes, taken once.
template <class Voxel>
WARPSCOPE_HD inline CellPairs pairsOf(const VoxelCell<Voxel>& cell, const ValueScale& scale) {
  CellPairs pairs;
  if constexpr (kIsRaised<Voxel>) {
    float raised[8];
    raisedCorners(cell, raised);
    for (int i = 0; i < 4; ++i) {
      pairs.lower[i] = raised[2 * i] - kRaise<Voxel>;
      pairs.rise[i] = raised[2 * i + 1] - raised[2 * i];
    }
  } else {
    for (int i = 0; i < 4; ++i) {
      pairs.lower[i] = interpolant(cell.corners[2 * i], scale);
      pairs.rise[i] = interpolant(cell.corners[2 * i + 1], scale) - pairs.lower[i];
    }
  }
  return pairs;
}

/// Where a sample lies: the cell, and its upper corners' weights.
struct SampleCell {
  int index[3] = {};
  float weight[3] = {};
};

/// trilinear() of a cell, bit for bit.
WARPSCOPE_HD inline float trilinear(const CellPairs& cell, float wx, float wy, float wz) {
  float edge[4];
  for (int i = 0; i < 4; ++i) edge[i] = mulAdd(wx, cell.rise[i], cell.lower[i]);
  return lerp(lerp(edge[0], edge[1], wy), lerp(edge[2], edge[3], wy), wz);
}

/// Gathers the cell whose lower voxel is `cell`, from -1 to the last voxel along each axis: where there is no voxel the outermost one counts once more. So
/// values beyond the outermost centres are those between equal corners.
template <class Voxel>
WARPSCOPE_HD inline VoxelCell<Voxel> voxelCellAt(const Voxel* voxels, const glm::ivec3& dims, const glm::ivec3& cell) {
  VoxelCell<Voxel> gathered;
  for (int i = 0; i < 8; ++i) {
    const glm::ivec3 at = glm::clamp(cell + glm::ivec3(i & 1, i >> 1 & 1, i >> 2), glm::ivec3(0), dims - 1);
    gathered.corners[i] = voxels[(static_cast<size_t>(at.z) * static_cast<size_t>(dims.y) + static_cast<size_t>(at.y)) * static_cast<size_t>(dims.x) +
                                 static_cast<size_t>(at.x)];
  }
  return gathered;
}

/// trilinear, bit for bit, where all corners are finite; else those that are not have no weight. NaN if they carry half the weight or more.
WARPSCOPE_HD inline float trilinearOfFinite(const float (&c)[8], float wx, float wy, float wz) {
  bool whole = true;
  for (int i = 0; i < 8; ++i) whole = whole && isFiniteVoxel(c[i]);
  if (whole) return trilinear(c, wx, wy, wz);
  // Relative to one of them, so that equal values stay what they are.
  float reference = 0.0f;
  for (int i = 8; i-- > 0;) reference = isFiniteVoxel(c[i]) ? c[i] : reference;
  float sum = 0.0f;
  float weights = 0.0f;
  for (int i = 0; i < 8; ++i) {
    const float weight = (i & 1 ? wx : 1.0f - wx) * (i & 2 ? wy : 1.0f - wy) * (i & 4 ? wz : 1.0f - wz);
    if (!isFiniteVoxel(c[i])) continue;
    sum += weight * (c[i] - reference);
    weights += weight;
  }
  return weights > 0.5f ? reference + sum / weights : NAN;
}

}  // namespace warpscope
