// Vectors' lanes one by one: numbers at places of their own, conditions as bits.
// xsimd; host only. As simd.h, beside which it stands since few need it.
#pragma once

#include <cstdint>

#include "render/core/simd.h"

namespace warpscope {

/// Bit k is set if the condition holds for the k-th.
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
/// The numbers at these places from `numbers` on; none is negative.
inline FloatBatch gathered(const float* numbers, const IntBatch& places) {
#if XSIMD_WITH_AVX512F
  return _mm512_i32gather_ps(places, numbers, 4);
#elif XSIMD_WITH_AVX2
  return _mm256_i32gather_ps(numbers, places, 4);
#else
  alignas(64) int32_t at[kBatchLanes];
  alignas(64) float values[kBatchLanes];
  places.store_aligned(at);
  for (int i = 0; i < kBatchLanes; ++i) values[i] = numbers[at[i]];
  return FloatBatch::load_aligned(values);
#endif
}

}  // namespace warpscope
