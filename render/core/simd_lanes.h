// Vectors' lanes one by one: numbers at places of their own.
// xsimd; host only. As simd.h, beside which it stands since few need it.
#pragma once

#include <cstdint>

#include "render/core/simd.h"

namespace warpscope {

/// The numbers at these places from `numbers` on; none is negative.
inline IntBatch gathered(const uint32_t* numbers, const IntBatch& places) {
#if XSIMD_WITH_AVX512F
  return _mm512_i32gather_epi32(places, numbers, 4);
#elif XSIMD_WITH_AVX2
  return _mm256_i32gather_epi32(reinterpret_cast<const int*>(numbers), places, 4);
#else
  alignas(64) int32_t at[kBatchLanes], values[kBatchLanes];
  places.store_aligned(at);
  for (int i = 0; i < kBatchLanes; ++i) values[i] = static_cast<int32_t>(numbers[at[i]]);
  return IntBatch::load_aligned(values);
#endif
}
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

/// The same of bytes, of which there are three more behind the last place.
inline IntBatch gatheredBytes(const uint8_t* numbers, const IntBatch& places) {
#if XSIMD_WITH_AVX512F
  return _mm512_and_si512(_mm512_i32gather_epi32(places, numbers, 1), _mm512_set1_epi32(255));
#elif XSIMD_WITH_AVX2
  return _mm256_and_si256(_mm256_i32gather_epi32(reinterpret_cast<const int*>(numbers), places, 1), _mm256_set1_epi32(255));
#else
  alignas(64) int32_t at[kBatchLanes], values[kBatchLanes];
  places.store_aligned(at);
  for (int i = 0; i < kBatchLanes; ++i) values[i] = numbers[at[i]];
  return IntBatch::load_aligned(values);
#endif
}

/// Two numbers beside each other, of each lane from another place on: numbers[place], numbers[place + 1]. Of all lanes these are numbers; no place is negative.
struct Pairs {
  IntBatch first, second;
};
inline Pairs gatheredPairs(const uint32_t* numbers, const IntBatch& places) {
#if XSIMD_WITH_AVX512F
  const __m512i low = _mm512_i32gather_epi64(_mm512_castsi512_si256(places), numbers, 4), high = _mm512_i32gather_epi64(_mm512_extracti64x4_epi64(places, 1), numbers, 4);
  const __m512i firsts = _mm512_setr_epi32(0, 2, 4, 6, 8, 10, 12, 14, 16, 18, 20, 22, 24, 26, 28, 30);
  return {_mm512_permutex2var_epi32(low, firsts, high), _mm512_permutex2var_epi32(low, _mm512_add_epi32(firsts, _mm512_set1_epi32(1)), high)};
#else
  return {gathered(numbers, places), gathered(numbers, places + IntBatch(1))};
#endif
}
/// The same of numbers[2 place] and numbers[2 place + 1]. One load a lane instead of two.
struct FloatPairs {
  FloatBatch first, second;
};
inline FloatPairs gatheredFloatPairs(const float* numbers, const IntBatch& places) {
#if XSIMD_WITH_AVX512F
  const __m512 low = _mm512_castpd_ps(_mm512_i32gather_pd(_mm512_castsi512_si256(places), numbers, 8));
  const __m512 high = _mm512_castpd_ps(_mm512_i32gather_pd(_mm512_extracti64x4_epi64(places, 1), numbers, 8));
  const __m512i firsts = _mm512_setr_epi32(0, 2, 4, 6, 8, 10, 12, 14, 16, 18, 20, 22, 24, 26, 28, 30);
  return {_mm512_permutex2var_ps(low, firsts, high), _mm512_permutex2var_ps(low, _mm512_add_epi32(firsts, _mm512_set1_epi32(1)), high)};
#elif XSIMD_WITH_AVX2
  const auto* pairs = reinterpret_cast<const double*>(numbers);
  const __m256 low = _mm256_castpd_ps(_mm256_i32gather_pd(pairs, _mm256_castsi256_si128(places), 8));
  const __m256 high = _mm256_castpd_ps(_mm256_i32gather_pd(pairs, _mm256_extracti128_si256(places, 1), 8));
  const auto inOrder = [](__m256 halves) { return _mm256_castpd_ps(_mm256_permute4x64_pd(_mm256_castps_pd(halves), 0xd8)); };
  return {inOrder(_mm256_shuffle_ps(low, high, 0x88)), inOrder(_mm256_shuffle_ps(low, high, 0xdd))};
#else
  alignas(64) int32_t at[kBatchLanes];
  alignas(64) float values[2][kBatchLanes];
  places.store_aligned(at);
  for (int i = 0; i < kBatchLanes; ++i)
    for (int j = 0; j < 2; ++j) values[j][i] = numbers[size_t{2} * static_cast<uint32_t>(at[i]) + static_cast<size_t>(j)];
  return {FloatBatch::load_aligned(values[0]), FloatBatch::load_aligned(values[1])};
#endif
}
/// Four numbers beside each other, of each lane from another place on: numbers[4 place] to numbers[4 place + 3]. One load a lane instead of four.
/// Of all lanes these are numbers; no place is negative.
struct Quads {
  FloatBatch of[4];
};
[[gnu::always_inline]] inline Quads gatheredQuads(const float* numbers, const IntBatch& places) {
  alignas(64) int32_t at[kBatchLanes];
  places.store_aligned(at);
#if XSIMD_WITH_AVX512F
  const auto quad = [&](int lane) { return _mm_loadu_ps(numbers + size_t{4} * static_cast<uint32_t>(at[lane])); };
  __m512 rows[4];  // row i: lanes i, 4 + i, 8 + i, 12 + i
  for (int i = 0; i < 4; ++i) {
    const __m256 low = _mm256_insertf128_ps(_mm256_castps128_ps256(quad(i)), quad(4 + i), 1), high = _mm256_insertf128_ps(_mm256_castps128_ps256(quad(8 + i)), quad(12 + i), 1);
    rows[i] = _mm512_castpd_ps(_mm512_insertf64x4(_mm512_castpd256_pd512(_mm256_castps_pd(low)), _mm256_castps_pd(high), 1));
  }
  const __m512 xy01 = _mm512_unpacklo_ps(rows[0], rows[1]), zw01 = _mm512_unpackhi_ps(rows[0], rows[1]);
  const __m512 xy23 = _mm512_unpacklo_ps(rows[2], rows[3]), zw23 = _mm512_unpackhi_ps(rows[2], rows[3]);
  return {{_mm512_shuffle_ps(xy01, xy23, 0x44), _mm512_shuffle_ps(xy01, xy23, 0xee), _mm512_shuffle_ps(zw01, zw23, 0x44), _mm512_shuffle_ps(zw01, zw23, 0xee)}};
#elif XSIMD_WITH_AVX
  const auto quad = [&](int lane) { return _mm_loadu_ps(numbers + size_t{4} * static_cast<uint32_t>(at[lane])); };
  __m256 rows[4];  // row i: lanes i, 4 + i
  for (int i = 0; i < 4; ++i) rows[i] = _mm256_insertf128_ps(_mm256_castps128_ps256(quad(i)), quad(4 + i), 1);
  const __m256 xy01 = _mm256_unpacklo_ps(rows[0], rows[1]), zw01 = _mm256_unpackhi_ps(rows[0], rows[1]);
  const __m256 xy23 = _mm256_unpacklo_ps(rows[2], rows[3]), zw23 = _mm256_unpackhi_ps(rows[2], rows[3]);
  return {{_mm256_shuffle_ps(xy01, xy23, 0x44), _mm256_shuffle_ps(xy01, xy23, 0xee), _mm256_shuffle_ps(zw01, zw23, 0x44), _mm256_shuffle_ps(zw01, zw23, 0xee)}};
#else
  alignas(64) float values[4][kBatchLanes];
  for (int i = 0; i < kBatchLanes; ++i)
    for (int j = 0; j < 4; ++j) values[j][i] = numbers[size_t{4} * static_cast<uint32_t>(at[i]) + static_cast<size_t>(j)];
  return {{FloatBatch::load_aligned(values[0]), FloatBatch::load_aligned(values[1]), FloatBatch::load_aligned(values[2]), FloatBatch::load_aligned(values[3])}};
#endif
}

/// The other way: each lane's four to its place, of those lanes whose bit is set in `lanes`.
[[gnu::always_inline]] inline void scatterQuads(const Quads& quads, float* numbers, const IntBatch& places, uint32_t lanes) {
  alignas(64) int32_t at[kBatchLanes];
  places.store_aligned(at);
  const auto placeOf = [&](int lane) { return numbers + size_t{4} * static_cast<uint32_t>(at[lane]); };
#if XSIMD_WITH_AVX
  const auto put = [&](int lane, const __m128& quad) {
    if ((lanes >> lane & 1) != 0) _mm_storeu_ps(placeOf(lane), quad);
  };
#endif
#if XSIMD_WITH_AVX512F
  const __m512 xy01 = _mm512_unpacklo_ps(quads.of[0], quads.of[1]), xy23 = _mm512_unpackhi_ps(quads.of[0], quads.of[1]);
  const __m512 zw01 = _mm512_unpacklo_ps(quads.of[2], quads.of[3]), zw23 = _mm512_unpackhi_ps(quads.of[2], quads.of[3]);
  const __m512 rows[4] = {_mm512_shuffle_ps(xy01, zw01, 0x44), _mm512_shuffle_ps(xy01, zw01, 0xee), _mm512_shuffle_ps(xy23, zw23, 0x44), _mm512_shuffle_ps(xy23, zw23, 0xee)};
  for (int i = 0; i < 4; ++i) {  // row i: lanes i, 4 + i, 8 + i, 12 + i
    put(i, _mm512_castps512_ps128(rows[i]));
    put(4 + i, _mm512_extractf32x4_ps(rows[i], 1));
    put(8 + i, _mm512_extractf32x4_ps(rows[i], 2));
    put(12 + i, _mm512_extractf32x4_ps(rows[i], 3));
  }
#elif XSIMD_WITH_AVX
  const __m256 xy01 = _mm256_unpacklo_ps(quads.of[0], quads.of[1]), xy23 = _mm256_unpackhi_ps(quads.of[0], quads.of[1]);
  const __m256 zw01 = _mm256_unpacklo_ps(quads.of[2], quads.of[3]), zw23 = _mm256_unpackhi_ps(quads.of[2], quads.of[3]);
  const __m256 rows[4] = {_mm256_shuffle_ps(xy01, zw01, 0x44), _mm256_shuffle_ps(xy01, zw01, 0xee), _mm256_shuffle_ps(xy23, zw23, 0x44), _mm256_shuffle_ps(xy23, zw23, 0xee)};
  for (int i = 0; i < 4; ++i) {  // row i: lanes i, 4 + i
    put(i, _mm256_castps256_ps128(rows[i]));
    put(4 + i, _mm256_extractf128_ps(rows[i], 1));
  }
#else
  alignas(64) float values[4][kBatchLanes];
  for (int j = 0; j < 4; ++j) quads.of[j].store_aligned(values[j]);
  for (int i = 0; i < kBatchLanes; ++i)
    if ((lanes >> i & 1) != 0)
      for (int j = 0; j < 4; ++j) placeOf(i)[j] = values[j][i];
#endif
}

/// Each shifted by as many bits as its own number says, at most 31; the sign bit comes in from the left.
inline IntBatch shiftedRight(const IntBatch& a, const IntBatch& bits) {
#if XSIMD_WITH_AVX512F
  return _mm512_srav_epi32(a, bits);  // xsimd 8 does it one by one
#else
  return a >> bits;
#endif
}
inline IntBatch shiftedLeft(const IntBatch& a, const IntBatch& bits) {
#if XSIMD_WITH_AVX512F
  return _mm512_sllv_epi32(a, bits);
#else
  return a << bits;
#endif
}

}  // namespace warpscope
