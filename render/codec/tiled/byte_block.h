// Sixty-four bytes side by side: which of them are the same as one, a bit each, the first the lowest. With the vectors that every x86-64 has, or better ones; nothing of it on
// other processors.
#pragma once

#if defined(__SSE2__)
#define WARPSCOPE_HAS_BYTE_BLOCKS 1

#include <immintrin.h>

#include <cstddef>
#include <cstdint>

namespace warpscope {

class ByteBlock {
 public:
  static constexpr size_t kSize = 64;

#if defined(__AVX512BW__)
  explicit ByteBlock(const uint8_t* bytes) : bytes_(_mm512_loadu_si512(bytes)) {}
  uint64_t equalTo(uint8_t byte) const { return _mm512_cmpeq_epi8_mask(bytes_, _mm512_set1_epi8(static_cast<char>(byte))); }

 private:
  __m512i bytes_;
#elif defined(__AVX2__)
  explicit ByteBlock(const uint8_t* bytes) : lower_(load(bytes)), upper_(load(bytes + 32)) {}
  uint64_t equalTo(uint8_t byte) const { return bits(lower_, byte) | bits(upper_, byte) << 32; }

 private:
  static __m256i load(const uint8_t* bytes) { return _mm256_loadu_si256(reinterpret_cast<const __m256i*>(bytes)); }
  static uint64_t bits(__m256i bytes, uint8_t byte) { return static_cast<uint32_t>(_mm256_movemask_epi8(_mm256_cmpeq_epi8(bytes, _mm256_set1_epi8(static_cast<char>(byte))))); }

  __m256i lower_, upper_;
#else
  explicit ByteBlock(const uint8_t* bytes) {
    for (size_t i = 0; i < kParts; ++i) parts_[i] = _mm_loadu_si128(reinterpret_cast<const __m128i*>(bytes + 16 * i));
  }
  uint64_t equalTo(uint8_t byte) const {
    uint64_t bits = 0;
    for (size_t i = 0; i < kParts; ++i)
      bits |= uint64_t{static_cast<uint32_t>(_mm_movemask_epi8(_mm_cmpeq_epi8(parts_[i], _mm_set1_epi8(static_cast<char>(byte)))))} << 16 * i;
    return bits;
  }

 private:
  static constexpr size_t kParts = kSize / sizeof(__m128i);

  __m128i parts_[kParts];
#endif
};

}  // namespace warpscope

#endif
