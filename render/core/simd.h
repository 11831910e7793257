// Vectors of floats and integers as wide as the processor's, with the few functions that formulas shared with scalar code need.
// xsimd; host only.
#pragma once

#include <cstdint>
#include <xsimd/xsimd.hpp>

#include "render/core/numeric.h"

namespace warpscope {

using FloatBatch = xsimd::batch<float>;
using IntBatch = xsimd::batch<int32_t>;
using UintBatch = xsimd::batch<uint32_t>;
inline constexpr int kBatchLanes = static_cast<int>(FloatBatch::size);

/// Bit k is set if the condition holds for the k-th. Wherever conditions are: with AVX-512 they convert to whole numbers, and bitsOf() of a number (numeric.h) would be called instead.
inline uint32_t bitsOf(const xsimd::batch_bool<float>& condition) {
#if XSIMD_WITH_AVX512F
  return condition.data;
#elif XSIMD_WITH_AVX
  return static_cast<uint32_t>(_mm256_movemask_ps(condition));
#else
  alignas(64) float values[kBatchLanes];
  xsimd::select(condition, FloatBatch(1.0f), FloatBatch(0.0f)).store_aligned(values);
  uint32_t bits = 0;
  for (int i = 0; i < kBatchLanes; ++i) bits |= static_cast<uint32_t>(values[i] != 0.0f) << i;
  return bits;
#endif
}

}  // namespace warpscope

// Templates find these by the namespace of their arguments, wherever they were defined.
namespace xsimd {

inline batch<float> mulAdd(const batch<float>& a, const batch<float>& b, const batch<float>& c) {
#if XSIMD_WITH_AVX512F
  return _mm512_fmadd_ps(a, b, c);  // xsimd 8 has no fma for these: its general one rounds twice, where one number at a time rounds once
#elif defined(__FMA__) || defined(__ARM_FEATURE_FMA)
  return fma(a, b, c);
#else
  constexpr std::size_t lanes = batch<float>::size;  // xsimd's would round twice
  alignas(64) float x[lanes], y[lanes], z[lanes];
  a.store_aligned(x);
  b.store_aligned(y);
  c.store_aligned(z);
  for (std::size_t i = 0; i < lanes; ++i) z[i] = warpscope::mulAdd(x[i], y[i], z[i]);
  return batch<float>::load_aligned(z);
#endif
}
inline batch<float> minOf(const batch<float>& a, const batch<float>& b) { return min(a, b); }
inline batch<float> maxOf(const batch<float>& a, const batch<float>& b) { return max(a, b); }
inline batch<int32_t> minOf(const batch<int32_t>& a, const batch<int32_t>& b) { return min(a, b); }
inline batch<float> saturated(const batch<float>& a) { return min(max(a, batch<float>(0.0f)), batch<float>(1.0f)); }
inline batch<float> sqrtOf(const batch<float>& a) { return sqrt(a); }
inline batch<float> cbrtOf(const batch<float>& a) { return cbrt(a); }
inline batch<float> powOf(const batch<float>& a, const batch<float>& exponent) { return pow(a, exponent); }
inline batch<float> absOf(const batch<float>& a) { return abs(a); }
inline batch<float> selected(const batch_bool<float>& condition, const batch<float>& ifTrue, const batch<float>& ifFalse) {
  return select(condition, ifTrue, ifFalse);
}
inline batch<int32_t> truncated(const batch<float>& a) { return to_int(a); }
inline batch<int32_t> truncatedWithin(const batch<float>& a, int largest) {
  return to_int(min(max(a, batch<float>(0.0f)), batch<float>(static_cast<float>(largest))));
}
inline batch<int32_t> truncatedTo(const batch<float>& a, const batch<int32_t>& largest) { return min(truncated(a), largest); }
inline batch<float> converted(const batch<int32_t>& a) { return to_float(a); }
inline batch<int32_t> bitsOf(const batch<float>& a) { return bitwise_cast<batch<int32_t>>(a); }
inline batch<float> floatOfBits(const batch<int32_t>& bits) { return bitwise_cast<batch<float>>(bits); }

}  // namespace xsimd
