// One value of all lanes of a warp, which must all call.
// CUDA C++ Programming Guide, warp shuffle and warp reduce functions.
#pragma once

#include <cstdint>

#include "render/core/box.h"
#include "render/core/numeric.h"

namespace warpscope {

constexpr uint32_t kAllLanes = 0xffffffffu;

/// Least and greatest of values that are not negative: such floats are ordered as their bits are.
__device__ inline float warpMin(float value) {
  uint32_t bits = __float_as_uint(value);
#if __CUDA_ARCH__ >= 800
  bits = __reduce_min_sync(kAllLanes, bits);
#else
  for (int offset = 16; offset > 0; offset /= 2) bits = min(bits, __shfl_xor_sync(kAllLanes, bits, offset));
#endif
  return __uint_as_float(bits);
}
__device__ inline float warpMax(float value) {
  uint32_t bits = __float_as_uint(value);
#if __CUDA_ARCH__ >= 800
  bits = __reduce_max_sync(kAllLanes, bits);
#else
  for (int offset = 16; offset > 0; offset /= 2) bits = max(bits, __shfl_xor_sync(kAllLanes, bits, offset));
#endif
  return __uint_as_float(bits);
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
