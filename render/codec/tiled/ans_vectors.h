// States of a stream side by side in vector registers: kAnsVectorLanes of kAnsLanes at once, with AVX-512 or AVX2. Bytes are those of one state after the other (ans.h).
// For ans_lanes.cpp; nothing of it where the processor has neither.
#pragma once

#if defined(__AVX512F__) || defined(__AVX2__)
#define WARPSCOPE_HAS_ANS_VECTORS 1

#include <immintrin.h>
#if defined(__AVX512F__) && !defined(__clang__)
// GCC 12's own header: registers that are left as they are on purpose.
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#pragma GCC diagnostic ignored "-Wuninitialized"
#endif

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include "render/codec/tiled/ans_lanes.h"
#include "render/codec/tokens.h"

namespace warpscope {

#if defined(__AVX512F__)
inline constexpr uint32_t kAnsVectorLanes = 16;
#else
inline constexpr uint32_t kAnsVectorLanes = 8;
#endif
static_assert(kAnsLanes % kAnsVectorLanes == 0);

/// A number a lane, and what comparing such gives: all bits of a lane or none. Operators are the compilers' own, lane by lane.
using AnsVector [[gnu::vector_size(kAnsVectorLanes * sizeof(uint32_t))]] = uint32_t;
using AnsCondition [[gnu::vector_size(kAnsVectorLanes * sizeof(int32_t))]] = int32_t;

/// Which lanes to take.
#if defined(__AVX512F__)
using AnsChoice = __mmask16;
#else
using AnsChoice = AnsCondition;
#endif

inline AnsVector loadedLanes(const uint32_t* numbers) {
  AnsVector lanes;
  std::memcpy(&lanes, numbers, sizeof lanes);
  return lanes;
}
inline void storeLanes(const AnsVector& lanes, uint32_t* numbers) { std::memcpy(numbers, &lanes, sizeof lanes); }

#if defined(__AVX512F__)

inline __m512i registerOf(const AnsVector& lanes) { return reinterpret_cast<__m512i>(lanes); }
inline AnsVector lanesOfRegister(const __m512i& lanes) { return reinterpret_cast<AnsVector>(lanes); }

inline AnsVector loadedLanes(const uint8_t* bytes) { return lanesOfRegister(_mm512_cvtepu8_epi32(_mm_loadu_si128(reinterpret_cast<const __m128i*>(bytes)))); }
inline void storeLanes(const AnsVector& lanes, uint8_t* bytes) { _mm_storeu_si128(reinterpret_cast<__m128i*>(bytes), _mm512_cvtepi32_epi8(registerOf(lanes))); }
inline AnsVector gatheredLanes(const uint32_t* numbers, const AnsVector& places) { return lanesOfRegister(_mm512_i32gather_epi32(registerOf(places), numbers, 4)); }
/// Which lanes of the first are less than those of the second: a bit each.
inline AnsChoice areLess(const AnsVector& a, const AnsVector& b) { return _mm512_cmplt_epu32_mask(registerOf(a), registerOf(b)); }
inline uint32_t bitsOf(AnsChoice choice) {
  uint32_t bits = choice;
  // GCC 12 may leave them in a mask's register, write its 16 bits to memory where such registers are few, and read 32 back.
  asm("" : "+r"(bits));
  return bits;
}
inline AnsVector chosen(AnsChoice choice, const AnsVector& a, const AnsVector& b) { return lanesOfRegister(_mm512_mask_mov_epi32(registerOf(b), choice, registerOf(a))); }

/// The upper halves of products.
inline AnsVector upperProduct(const AnsVector& a, const AnsVector& b) {
  const __m512i even = _mm512_srli_epi64(_mm512_mul_epu32(registerOf(a), registerOf(b)), 32);
  const __m512i odd = _mm512_mul_epu32(_mm512_srli_epi64(registerOf(a), 32), _mm512_srli_epi64(registerOf(b), 32));
  return lanesOfRegister(_mm512_mask_mov_epi32(even, 0xaaaa, odd));
}

static_assert(AnsWriterModel::kNear == 2 * kAnsVectorLanes);
/// What numbers are at places, of whose bits the lowest count: faster than from memory.
inline AnsVector nearLanes(const std::array<uint32_t, AnsWriterModel::kNear>& numbers, const AnsVector& places) {
  return lanesOfRegister(_mm512_permutex2var_epi32(registerOf(loadedLanes(numbers.data())), registerOf(places), registerOf(loadedLanes(numbers.data() + kAnsVectorLanes))));
}
/// Whether the symbols of all lanes are among those from `first` on.
inline bool areNear(const uint8_t* symbols, uint8_t first) {
  static_assert(kAnsLanes == 32);
  const __m256i all = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(symbols)), places = _mm256_sub_epi8(all, _mm256_set1_epi8(static_cast<char>(first)));
  return _mm256_testz_si256(places, _mm256_set1_epi8(static_cast<char>(~(AnsWriterModel::kNear - 1)))) != 0;
}

/// Puts the lower 16 bits of lanes whose bit is set in front of `at`. Returns where they begin.
inline uint16_t* putWords(const AnsVector& lanes, uint32_t bits, uint16_t* at) {
  const int words = std::popcount(bits);
  at -= words;
  _mm512_mask_cvtepi32_storeu_epi16(at, static_cast<__mmask16>((1u << words) - 1), _mm512_maskz_compress_epi32(static_cast<__mmask16>(bits), registerOf(lanes)));
  return at;
}
/// A word for each lane whose bit is set, in their order. kAnsVectorLanes words are there.
inline AnsVector wordsFor(uint32_t bits, const std::byte* at) {
  return lanesOfRegister(_mm512_maskz_expand_epi32(static_cast<__mmask16>(bits), _mm512_cvtepu16_epi32(_mm256_loadu_si256(reinterpret_cast<const __m256i*>(at)))));
}

#else

inline __m256i registerOf(const AnsVector& lanes) { return reinterpret_cast<__m256i>(lanes); }
inline AnsVector lanesOfRegister(const __m256i& lanes) { return reinterpret_cast<AnsVector>(lanes); }

inline AnsVector loadedLanes(const uint8_t* bytes) { return lanesOfRegister(_mm256_cvtepu8_epi32(_mm_loadl_epi64(reinterpret_cast<const __m128i*>(bytes)))); }
inline void storeLanes(const AnsVector& lanes, uint8_t* bytes) {
  const __m256i inFours = _mm256_shuffle_epi8(registerOf(lanes), _mm256_set1_epi32(0x0c080400));
  _mm_storel_epi64(reinterpret_cast<__m128i*>(bytes), _mm_unpacklo_epi32(_mm256_castsi256_si128(inFours), _mm256_extracti128_si256(inFours, 1)));
}
inline AnsVector gatheredLanes(const uint32_t* numbers, const AnsVector& places) {
  return lanesOfRegister(_mm256_i32gather_epi32(reinterpret_cast<const int*>(numbers), registerOf(places), 4));
}
/// Which lanes of the first are less than those of the second: all their bits or none.
inline AnsChoice areLess(const AnsVector& a, const AnsVector& b) { return a < b; }
inline uint32_t bitsOf(const AnsChoice& choice) { return static_cast<uint32_t>(_mm256_movemask_ps(reinterpret_cast<__m256>(choice))); }
inline AnsVector chosen(const AnsChoice& choice, const AnsVector& a, const AnsVector& b) { return choice ? a : b; }

/// The upper halves of products.
inline AnsVector upperProduct(const AnsVector& a, const AnsVector& b) {
  const __m256i even = _mm256_srli_epi64(_mm256_mul_epu32(registerOf(a), registerOf(b)), 32);
  const __m256i odd = _mm256_mul_epu32(_mm256_srli_epi64(registerOf(a), 32), _mm256_srli_epi64(registerOf(b), 32));
  return lanesOfRegister(_mm256_blend_epi32(even, odd, 0xaa));
}

/// For each choice of lanes, eight lanes: where those of the choice go to and come from.
struct LaneChoices {
  alignas(64) std::array<std::array<uint8_t, kAnsVectorLanes>, 1u << kAnsVectorLanes> atEnd{};  ///< the chosen ones, in order, as the last ones; something in front
  alignas(64) std::array<std::array<uint8_t, kAnsVectorLanes>, 1u << kAnsVectorLanes> ranks{};  ///< of each lane, how many in front of it are chosen

  constexpr LaneChoices() {
    for (uint32_t bits = 0; bits < atEnd.size(); ++bits) {
      uint32_t rank = 0;
      auto place = kAnsVectorLanes - static_cast<uint32_t>(std::popcount(bits));
      for (uint32_t lane = 0; lane < kAnsVectorLanes; ++lane) {
        ranks[bits][lane] = static_cast<uint8_t>(rank);
        if ((bits >> lane & 1u) == 0) continue;
        ++rank;
        atEnd[bits][place++] = static_cast<uint8_t>(lane);
      }
    }
  }
};
inline constexpr LaneChoices kLaneChoices;

/// Puts the lower 16 bits of lanes whose bit is set in front of `at`. Returns where they begin. What is in front of these, up to kAnsVectorLanes words in front of `at`, is lost.
inline uint16_t* putWords(const AnsVector& lanes, uint32_t bits, uint16_t* at) {
  const __m256i atEnd = _mm256_permutevar8x32_epi32(registerOf(lanes & 0xffffu), registerOf(loadedLanes(kLaneChoices.atEnd[bits].data())));
  _mm_storeu_si128(reinterpret_cast<__m128i*>(at - kAnsVectorLanes), _mm_packus_epi32(_mm256_castsi256_si128(atEnd), _mm256_extracti128_si256(atEnd, 1)));
  return at - std::popcount(bits);
}
/// A word for each lane whose bit is set, in their order; others have something. kAnsVectorLanes words are there.
inline AnsVector wordsFor(uint32_t bits, const std::byte* at) {
  const __m256i words = _mm256_cvtepu16_epi32(_mm_loadu_si128(reinterpret_cast<const __m128i*>(at)));
  return lanesOfRegister(_mm256_permutevar8x32_epi32(words, registerOf(loadedLanes(kLaneChoices.ranks[bits].data()))));
}

#endif

/// States that have given what they have to, behind what others gave. Returns where words begin.
inline uint16_t* giveWords(AnsVector& states, const AnsChoice& give, uint16_t* at) {
  at = putWords(states, bitsOf(give), at);
  states = chosen(give, states >> 16, states);
  return at;
}

/// AnsWriterShare::gives() and put() of a symbol a lane. Returns where words begin.
inline uint16_t* putLanes(const AnsVector& multiplier, const AnsVector& parts, AnsVector& states, uint16_t* at) {
  const AnsVector frequency = parts >> AnsWriterShare::kFrequencyAt & (2 * kAnsScale - 1);
  at = giveWords(states, areLess((frequency << (32 - kAnsBits)) - 1u, states), at);
  // A state that has given is less than 2^32 - 2^20: one more is still a word.
  const AnsVector quotient = upperProduct(states + (parts >> AnsWriterShare::kAddsAt), multiplier) >> (parts >> AnsWriterShare::kShiftAt & 15u);
  states += (parts & (kAnsScale - 1)) + quotient * (kAnsScale - frequency);
  return at;
}

/// restBits() of numbers' tokens.
inline AnsVector restsOf(const AnsVector& numbers) {
  // The exponent of a float is where the highest bit is, if nothing is rounded up: without the second highest nothing is.
  using Floats [[gnu::vector_size(kAnsVectorLanes * sizeof(float))]] = float;
  const auto steep = reinterpret_cast<AnsCondition>(numbers & ~(numbers >> 1));
  const auto exponent = reinterpret_cast<AnsVector>(__builtin_convertvector(steep, Floats)) >> 23;
  const AnsVector length = steep < 0 ? AnsVector{} + 32u : exponent - 126u;
  return numbers < kDirectTokens ? AnsVector{} : length - 2u;
}
/// tokenOf(). `rests`: restsOf() them.
inline AnsVector tokensOf(const AnsVector& numbers, const AnsVector& rests) {
  return numbers < kDirectTokens ? numbers : kDirectTokens + 2u * (rests - 3u) + (numbers >> rests & 1u);
}
/// Of `rests` bits, those from bit `shift` on that a state takes at once. `shift`: 0 or kAnsRestBits.
inline AnsVector restsAt(const AnsVector& rests, uint32_t shift) {
  const AnsVector left = rests > shift ? rests - shift : AnsVector{};
  return left > kAnsRestBits ? AnsVector{} + kAnsRestBits : left;
}

/// ansGivesForBits() and ansPutBits() of numbers' rests from bit `shift` on. Returns where words begin.
inline uint16_t* putRestLanes(const uint32_t* numbers, uint32_t shift, AnsVector& states, uint16_t* at) {
  const AnsVector number = loadedLanes(numbers), count = restsAt(restsOf(number), shift);
  at = giveWords(states, areLess(AnsVector{}, states >> (31u - count) >> 1), at);
  states = states << count | (number >> shift & ((1u << count) - 1u));
  return at;
}

/// States that took words where they want some. As many words are there as there are lanes.
inline AnsVector refilled(const AnsVector& states, const std::byte*& at) {
  const AnsChoice wants = areLess(states, AnsVector{} + kAnsLow);
  const uint32_t bits = bitsOf(wants);
  const AnsVector filled = states << 16 | wordsFor(bits, at);
  at += sizeof(uint16_t) * static_cast<size_t>(std::popcount(bits));
  return chosen(wants, filled, states);
}

/// What slots say of a state a lane. As many words are there as there are lanes. Returns whether any symbol is none of kDirectTokens.
template <class T>
inline bool takeLanes(const uint32_t* slots, AnsVector& states, const std::byte*& at, T* symbols) {
  const AnsVector slot = gatheredLanes(slots, states & (kAnsScale - 1)), symbol = slot & 255u;
  states = refilled((slot >> 8 & (kAnsScale - 1)) * (states >> kAnsBits) + (slot >> 20), at);
  storeLanes(symbol, symbols);
  return bitsOf(areLess(AnsVector{} + (kDirectTokens - 1), symbol)) != 0;
}

/// restBits().
inline AnsVector restBitsOf(const AnsVector& tokens) {
  const AnsVector within = tokens < kLargestToken ? tokens : AnsVector{} + kLargestToken;
  return within < kDirectTokens ? AnsVector{} : ((within - kDirectTokens) >> 1) + 3u;
}
/// Adds to `rests` what tokens want from bit `shift` on. As many words are there as there are lanes.
inline void takeRestLanes(const uint32_t* tokens, uint32_t shift, AnsVector& states, const std::byte*& at, uint32_t* rests) {
  const AnsVector count = restsAt(restBitsOf(loadedLanes(tokens)), shift);
  storeLanes(loadedLanes(rests) | (states & ((1u << count) - 1u)) << shift, rests);
  states = refilled(states >> count, at);
}
/// valueOf(): tokens become the numbers.
inline void makeNumbers(uint32_t* tokens, const uint32_t* rests) {
  const AnsVector token = loadedLanes(tokens);
  storeLanes(token < kDirectTokens ? token : (2u + (token & 1u)) << restBitsOf(token) | loadedLanes(rests), tokens);
}

/// All states of a stream, in registers for as long as this is there.
class AnsStates {
 public:
  explicit AnsStates(std::array<uint32_t, kAnsLanes>& states) : states_(states) {
    forEach([&](uint32_t lane, AnsVector& own) { own = loadedLanes(states_.data() + lane); });
  }
  AnsStates(const AnsStates&) = delete;
  AnsStates& operator=(const AnsStates&) = delete;
  ~AnsStates() {
    forEach([&](uint32_t lane, AnsVector& own) { storeLanes(own, states_.data() + lane); });
  }

  /// What a writer does with a step (SingleStates in ans_lanes.cpp).
  uint16_t* put(const AnsWriterModel& model, const uint8_t* symbols, uint16_t* at) {
#if defined(__AVX512F__)
    if (areNear(symbols, model.nearest)) {
      forEachFromTheEnd([&](uint32_t lane, AnsVector& own) {
        const AnsVector place = loadedLanes(symbols + lane) - uint32_t{model.nearest};  // its lowest bits count
        at = putLanes(nearLanes(model.nearMultipliers, place), nearLanes(model.nearParts, place), own, at);
      });
      return at;
    }
#endif
    forEachFromTheEnd([&](uint32_t lane, AnsVector& own) {
      const AnsVector symbol = loadedLanes(symbols + lane);
      at = putLanes(gatheredLanes(model.multipliers.data(), symbol), gatheredLanes(model.parts.data(), symbol), own, at);
    });
    return at;
  }
  uint16_t* putRests(const uint32_t* numbers, uint32_t shift, uint16_t* at) {
    forEachFromTheEnd([&](uint32_t lane, AnsVector& own) { at = putRestLanes(numbers + lane, shift, own, at); });
    return at;
  }

  /// f(number of a vector's first lane, its states).
  template <class F>
  void forEach(const F& f) {
    for (uint32_t v = 0; v < kVectors; ++v) f(v * kAnsVectorLanes, vectors_[v]);
  }
  template <class F>
  void forEachFromTheEnd(const F& f) {
    for (uint32_t v = kVectors; v-- > 0;) f(v * kAnsVectorLanes, vectors_[v]);
  }

 private:
  static constexpr uint32_t kVectors = kAnsLanes / kAnsVectorLanes;

  std::array<uint32_t, kAnsLanes>& states_;
  AnsVector vectors_[kVectors];
};

}  // namespace warpscope

#endif
