// What formulas need of a number, for float and int; simd.h has the same for vectors of them, so that one formula serves a sample at a time
// and a batch. Comparisons with NaN choose the second argument, as the processors' own minimum and maximum do.
#pragma once

#include "render/core/host_device.h"

#include <cmath>

namespace warpscope {

#if defined(__CUDA_ARCH__)
WARPSCOPE_HD inline float minOf(float a, float b) { return fminf(a, b); }  // one instruction; the second is no NaN anywhere
WARPSCOPE_HD inline float maxOf(float a, float b) { return fmaxf(a, b); }
#else
WARPSCOPE_HD inline float minOf(float a, float b) { return a < b ? a : b; }
WARPSCOPE_HD inline float maxOf(float a, float b) { return a > b ? a : b; }
#endif
WARPSCOPE_HD inline int minOf(int a, int b) { return a < b ? a : b; }
WARPSCOPE_HD inline int maxOf(int a, int b) { return a > b ? a : b; }
/// `a` within [0, 1]; 0 for NaN.
WARPSCOPE_HD inline float saturated(float a) {
#if defined(__CUDA_ARCH__)
  return __saturatef(a);  // no instruction of its own
#else
  return minOf(maxOf(a, 0.0f), 1.0f);
#endif
}
/// a * b + c in one rounding, where the processor has an instruction for it (every CUDA device, x86 since 2013); else in two.
WARPSCOPE_HD inline float mulAdd(float a, float b, float c) {
#if defined(__CUDA_ARCH__) || defined(__FMA__) || defined(__ARM_FEATURE_FMA)
  return std::fma(a, b, c);
#else
  return a * b + c;
#endif
}
WARPSCOPE_HD inline float sqrtOf(float a) { return std::sqrt(a); }
WARPSCOPE_HD inline float cbrtOf(float a) { return std::cbrt(a); }
WARPSCOPE_HD inline float powOf(float a, float exponent) { return std::pow(a, exponent); }
WARPSCOPE_HD inline float absOf(float a) { return std::abs(a); }
WARPSCOPE_HD inline float selected(bool condition, float ifTrue, float ifFalse) { return condition ? ifTrue : ifFalse; }
WARPSCOPE_HD inline int truncated(float a) { return static_cast<int>(a); }
/// minOf(truncated(a), largest), for `a` in [0, 2^23).
WARPSCOPE_HD inline int truncatedTo(float a, int largest) {
#if defined(__CUDA_ARCH__)
  // Rounded down behind the exponent of 2^23: an addition and a minimum, where a conversion would queue for the slow unit.
  return minOf(__float_as_int(__fadd_rz(a, 8388608.0f)) - 0x4b000000, largest);
#else
  return minOf(truncated(a), largest);
#endif
}
WARPSCOPE_HD inline float converted(int a) { return static_cast<float>(a); }

}  // namespace warpscope
