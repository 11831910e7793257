// One value of all lanes of a warp, or sums up to each; all must call.
// CUDA C++ Programming Guide, warp shuffle and warp reduce functions.
#pragma once

#include <cstdint>

#include "render/core/box.h"
#include "render/core/numeric.h"

namespace warpscope {

constexpr uint32_t kAllLanes = 0xffffffffu;

/// Least and greatest, of floats that are not negative: such are ordered as their bits are.
__device__ inline float warpMin(float value) {
  uint32_t bits = __float_as_uint(value);
#if __CUDA_ARCH__ >= 800
  bits = __reduce_min_sync(kAllLanes, bits);
#else
  for (int offset = 16; offset > 0; offset /= 2) bits = min(bits, __shfl_xor_sync(kAllLanes, bits, offset));
#endif
  return __uint_as_float(bits);
}

__device__ inline uint32_t warpMax(uint32_t value) {
#if __CUDA_ARCH__ >= 800
  return __reduce_max_sync(kAllLanes, value);
#else
  for (int offset = 16; offset > 0; offset /= 2) value = max(value, __shfl_xor_sync(kAllLanes, value, offset));
  return value;
#endif
}
__device__ inline float warpMax(float value) { return __uint_as_float(warpMax(__float_as_uint(value))); }

/// The bits that any lane has.
__device__ inline uint32_t warpOr(uint32_t bits) {
#if __CUDA_ARCH__ >= 800
  return __reduce_or_sync(kAllLanes, bits);
#else
  for (int offset = 16; offset > 0; offset /= 2) bits |= __shfl_xor_sync(kAllLanes, bits, offset);
  return bits;
#endif
}

/// Sums of a value that each lane has.
struct WarpSums {
  uint32_t before;  ///< of the lanes before this one
  uint32_t all;
};
__device__ inline WarpSums warpSums(uint32_t value) {
  const unsigned lane = threadIdx.x % 32;
  uint32_t upTo = value;
  for (unsigned offset = 1; offset < 32; offset *= 2) {
    const uint32_t other = __shfl_up_sync(kAllLanes, upTo, offset);
    if (lane >= offset) upTo += other;
  }
  return {upTo - value, __shfl_sync(kAllLanes, upTo, 31)};
}

/// The box around all lanes' boxes, empty ones left out.
__device__ inline Box boxOfWarp(Box box) {
  for (int axis = 0; axis < 3; ++axis)
    for (int offset = 16; offset > 0; offset /= 2) {
      box.lower[axis] = minOf(box.lower[axis], __shfl_xor_sync(kAllLanes, box.lower[axis], offset));
      box.upper[axis] = maxOf(box.upper[axis], __shfl_xor_sync(kAllLanes, box.upper[axis], offset));
    }
  return box;
}

}  // namespace warpscope
