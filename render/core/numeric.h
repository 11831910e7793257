// What formulas need of a number, for float and int; simd.h has the same for vectors of them, so that one formula serves a sample at a time
// and a batch. Comparisons with NaN choose the second argument, as the processors' own minimum and maximum do.
#pragma once

#include "render/core/host_device.h"

#include <cmath>
#include <cstdint>
#include <cstring>

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
/// a * b + c in one rounding, by plain operations, for processors that have no instruction for it: the product is exact
/// in double precision, and a sum that is not exact is made odd, so that rounding it once more gives what rounding once
/// would (Boldo, Melquiond 2008).
WARPSCOPE_HD inline float mulAddInDouble(float a, float b, float c) {
  const double product = static_cast<double>(a) * static_cast<double>(b);
  const double sum = product + static_cast<double>(c);
  const double fromProduct = sum - static_cast<double>(c);
  const double lost = (product - fromProduct) + (static_cast<double>(c) - (sum - fromProduct));
  uint64_t bits;
  std::memcpy(&bits, &sum, sizeof bits);
  const bool isInexact = lost > 0.0 || lost < 0.0;      // not where the sum is infinite
  const bool isTooSmall = (lost > 0.0) == (sum > 0.0);  // the true sum is farther from 0
  if (isInexact && (bits & 1) == 0) bits += isTooSmall ? uint64_t{1} : ~uint64_t{0};
  double odd;
  std::memcpy(&odd, &bits, sizeof odd);
  return static_cast<float>(odd);
}
/// a * b + c in one rounding, everywhere.
WARPSCOPE_HD inline float mulAdd(float a, float b, float c) {
#if defined(__CUDA_ARCH__) || defined(__FMA__) || defined(__ARM_FEATURE_FMA)
  return std::fma(a, b, c);
#else
  return mulAddInDouble(a, b, c);  // the library's function would be called, and stand in the way of vectors
#endif
}
WARPSCOPE_HD inline double mulAdd(double a, double b, double c) { return std::fma(a, b, c); }
WARPSCOPE_HD inline float sqrtOf(float a) { return std::sqrt(a); }
WARPSCOPE_HD inline float cbrtOf(float a) { return std::cbrt(a); }
WARPSCOPE_HD inline float powOf(float a, float exponent) { return std::pow(a, exponent); }
WARPSCOPE_HD inline float absOf(float a) { return std::abs(a); }
WARPSCOPE_HD inline float selected(bool condition, float ifTrue, float ifFalse) { return condition ? ifTrue : ifFalse; }
WARPSCOPE_HD inline int truncated(float a) { return static_cast<int>(a); }
/// `a` within [0, largest] without its fraction; 0 for NaN. `largest` < 2^24.
WARPSCOPE_HD inline int truncatedWithin(float a, int largest) {
#if defined(__CUDA_ARCH__)
  return static_cast<int>(min(__float2uint_rz(a), static_cast<unsigned>(largest)));  // the conversion makes what is below 0, and NaN, 0
#else
  return static_cast<int>(minOf(maxOf(a, 0.0f), static_cast<float>(largest)));
#endif
}
/// minOf(truncated(a), largest), for `a` in [0, 2^23).
WARPSCOPE_HD inline int truncatedTo(float a, int largest) {
#if defined(__CUDA_ARCH__)
  // Rounded down behind the exponent of 2^23: an addition and a minimum, where a conversion would queue for the slow unit.
  return minOf(__float_as_int(__fadd_rz(a, 8388608.0f)) - 0x4b000000, largest);
#else
  return minOf(truncated(a), largest);
#endif
}
/// The greatest whole number that is not above a number of less than 2^22 either way.
struct Floored {
  float whole;
  uint32_t raised;  ///< the same as an integer, and kRaised more
  static constexpr uint32_t kRaised = 0x4b400000u;
  WARPSCOPE_HD int index() const { return static_cast<int>(raised - kRaised); }
};
WARPSCOPE_HD inline Floored floored(float a) {
#if defined(__CUDA_ARCH__)
  // Rounded down behind the exponent of 2^23, with as much room for negative numbers: no conversion, which would queue for the slow unit.
  const float raised = __fadd_rd(a, 12582912.0f);
  return {raised - 12582912.0f, static_cast<uint32_t>(__float_as_int(raised))};
#else
  const float whole = std::floor(a);
  return {whole, Floored::kRaised + static_cast<uint32_t>(static_cast<int>(whole))};
#endif
}
/// The least integer that is not below `a`, at most `largest`; anything up to that for NaN.
WARPSCOPE_HD inline int ceiledTo(float a, int largest) {
#if defined(__CUDA_ARCH__)
  return min(__float2int_ru(a), largest);  // the conversion saturates
#else
  return static_cast<int>(std::ceil(minOf(maxOf(a, -1.0f), static_cast<float>(largest))));
#endif
}
WARPSCOPE_HD inline float converted(int a) { return static_cast<float>(a); }
/// A float's bits as an integer, and back.
WARPSCOPE_HD inline int32_t bitsOf(float a) {
  int32_t bits;
  std::memcpy(&bits, &a, sizeof bits);
  return bits;
}
WARPSCOPE_HD inline float floatOfBits(int32_t bits) {
  float a;
  std::memcpy(&a, &bits, sizeof a);
  return a;
}

}  // namespace warpscope
