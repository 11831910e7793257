// States side by side. Loops read and write through locals only: what they write cannot be what they read then.
// See ans_lanes.h.
#include "render/codec/tiled/ans_lanes.h"

#include <algorithm>
#include <bit>

#if defined(__AVX512F__)
#include <immintrin.h>
#if !defined(__clang__)
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"  // GCC 12's own header: registers that are left as they are on purpose
#endif
#endif

#include "render/codec/tokens.h"

namespace warpscope {
namespace {

constexpr size_t kWord = sizeof(uint16_t);

uint32_t stepsOf(size_t symbols) { return static_cast<uint32_t>((symbols + kAnsLanes - 1) / kAnsLanes); }
uint32_t lanesOf(size_t symbols, uint32_t step) { return static_cast<uint32_t>(std::min<size_t>(symbols - size_t{step} * kAnsLanes, kAnsLanes)); }

#if defined(__AVX512F__)

// 16 lanes at once; words are moved together and apart in registers.

__m512i symbolsOf(const uint8_t* symbols) { return _mm512_cvtepu8_epi32(_mm_loadu_si128(reinterpret_cast<const __m128i*>(symbols))); }
__m512i symbolsOf(const uint32_t* symbols) { return _mm512_loadu_si512(symbols); }

/// The upper halves of products.
__m512i upperProduct(__m512i a, __m512i b) {
  const __m512i even = _mm512_srli_epi64(_mm512_mul_epu32(a, b), 32);
  const __m512i odd = _mm512_mul_epu32(_mm512_srli_epi64(a, 32), _mm512_srli_epi64(b, 32));
  return _mm512_mask_mov_epi32(even, 0xaaaa, odd);
}

/// ansGives() and ansPut() of 16 symbols.
template <class T>
uint16_t* put16(const T* symbols, const AnsWriterModel& model, __m512i& state, uint16_t* at) {
  const __m512i symbol = symbolsOf(symbols);
  const __m512i share = _mm512_i32gather_epi32(symbol, model.shares.data(), 4), reciprocal = _mm512_i32gather_epi32(symbol, model.reciprocals.data(), 4);
  const __m512i frequency = _mm512_srli_epi32(share, 16), start = _mm512_and_si512(share, _mm512_set1_epi32(0xffff));
  const __mmask16 gives = _mm512_cmpge_epu32_mask(state, _mm512_slli_epi32(frequency, 32 - kAnsBits));
  const int words = std::popcount(static_cast<unsigned>(gives));
  at -= words;
  _mm512_mask_cvtepi32_storeu_epi16(at, static_cast<__mmask16>((1u << words) - 1), _mm512_maskz_compress_epi32(gives, state));
  state = _mm512_mask_srli_epi32(state, gives, state, 16);
  __m512i quotient = upperProduct(state, reciprocal), rest = _mm512_sub_epi32(state, _mm512_mullo_epi32(quotient, frequency));
  for (int correction = 0; correction < 2; ++correction) {
    const __mmask16 isLess = _mm512_cmpge_epu32_mask(rest, frequency);
    quotient = _mm512_mask_add_epi32(quotient, isLess, quotient, _mm512_set1_epi32(1));
    rest = _mm512_mask_sub_epi32(rest, isLess, rest, frequency);
  }
  state = _mm512_add_epi32(_mm512_add_epi32(_mm512_slli_epi32(quotient, kAnsBits), rest), start);
  return at;
}

/// What slots say of 16 states, which take words where they want some: there are as many. Returns the symbols.
__m512i take16(const uint32_t* slots, __m512i& state, const std::byte*& at) {
  const __m512i slot = _mm512_i32gather_epi32(_mm512_and_si512(state, _mm512_set1_epi32(kAnsScale - 1)), slots, 4);
  const __m512i frequency = _mm512_and_si512(_mm512_srli_epi32(slot, 8), _mm512_set1_epi32(kAnsScale - 1));
  state = _mm512_add_epi32(_mm512_mullo_epi32(frequency, _mm512_srli_epi32(state, kAnsBits)), _mm512_srli_epi32(slot, 20));
  const __mmask16 wants = _mm512_cmplt_epu32_mask(state, _mm512_set1_epi32(kAnsLow));
  const __m512i words = _mm512_cvtepu16_epi32(_mm256_loadu_si256(reinterpret_cast<const __m256i*>(at)));
  state = _mm512_mask_or_epi32(state, wants, _mm512_slli_epi32(state, 16), _mm512_maskz_expand_epi32(wants, words));
  at += kWord * static_cast<size_t>(std::popcount(static_cast<unsigned>(wants)));
  return _mm512_and_si512(slot, _mm512_set1_epi32(255));
}

void storeSymbols(uint8_t* to, __m512i symbols) { _mm_storeu_si128(reinterpret_cast<__m128i*>(to), _mm512_cvtepi32_epi8(symbols)); }
void storeSymbols(uint32_t* to, __m512i symbols) { _mm512_storeu_si512(to, symbols); }

#endif

/// The bits of a number behind its token that a state takes first, and those that are left.
uint32_t firstRest(uint32_t bits) { return std::min(bits, kAnsRestBits); }

}  // namespace

AnsWriterModel::AnsWriterModel(const AnsModel& theModel) : model(theModel) {
  for (uint32_t s = 0; s < kAnsSymbols; ++s) {
    const AnsShare share = model.share(s);
    shares[s] = share.start | share.frequency << 16;
    reciprocals[s] = ansReciprocal(share.frequency);
  }
}

void AnsWriter::begin() {
  states_.fill(kAnsLow);
  first_ = words_.size();
}

/// Room for so many words in front of those that there are. Returns the place of the first of these.
uint16_t* AnsWriter::reserve(size_t words) {
  if (first_ < words) {
    const size_t kept = words_.size() - first_, more = words + words_.size();
    std::vector<uint16_t> larger(words_.size() + more);
    std::copy(words_.end() - static_cast<std::ptrdiff_t>(kept), words_.end(), larger.end() - static_cast<std::ptrdiff_t>(kept));
    words_.swap(larger);
    first_ = words_.size() - kept;
  }
  return words_.data() + first_;
}

/// Puts the symbols of a step, one for each of the first lanes. Returns where words begin then.
template <class T>
uint16_t* AnsWriter::putStep(const AnsWriterModel& model, const T* symbols, uint32_t lanes, uint16_t* at) {
  uint32_t* const states = states_.data();
#if defined(__AVX512F__)
  if (lanes == kAnsLanes) {
    for (int half = 1; half >= 0; --half) {
      __m512i state = _mm512_loadu_si512(states + 16 * half);
      at = put16(symbols + 16 * half, model, state, at);
      _mm512_storeu_si512(states + 16 * half, state);
    }
    return at;
  }
#endif
  for (uint32_t lane = lanes; lane-- > 0;) {
    const AnsShare share = model.model.share(symbols[lane]);
    uint16_t word;
    if (ansGives(states[lane], share, word)) *--at = word;
    states[lane] = ansPut(states[lane], share);
  }
  return at;
}

void AnsWriter::putBytes(const AnsWriterModel& model, std::span<const uint8_t> symbols) {
  if (model.model.isConstant()) return;
  uint16_t* at = reserve(symbols.size());
  const uint16_t* const before = at;
  for (uint32_t step = stepsOf(symbols.size()); step-- > 0;) at = putStep(model, symbols.data() + size_t{step} * kAnsLanes, lanesOf(symbols.size(), step), at);
  first_ -= static_cast<size_t>(before - at);
}

void AnsWriter::putNumbers(const AnsWriterModel& model, std::span<const uint32_t> numbers) {
  constexpr size_t kMostWords = 3;  // of a token and both parts of its rest
  uint16_t* at = reserve(kMostWords * numbers.size());
  const uint16_t* const before = at;
  const uint32_t* const number = numbers.data();
  uint32_t* const states = states_.data();
  const bool isConstant = model.model.isConstant();
  const auto putRest = [&](uint32_t lane, uint32_t bits, uint32_t count) {
    uint16_t word;
    if (ansGivesForBits(states[lane], count, word)) *--at = word;
    states[lane] = ansPutBits(states[lane], bits, count);
  };
  for (uint32_t step = stepsOf(numbers.size()); step-- > 0;) {
    const uint32_t lanes = lanesOf(numbers.size(), step);
    const uint32_t* const own = number + size_t{step} * kAnsLanes;
    uint32_t any = 0;
    for (uint32_t lane = 0; lane < lanes; ++lane) any |= own[lane];
    if (any >= kDirectTokens) {
      for (uint32_t lane = lanes; lane-- > 0;) {
        const uint32_t rest = restBits(tokenOf(own[lane]));
        if (rest > kAnsRestBits) putRest(lane, own[lane] >> kAnsRestBits & ((1u << (rest - kAnsRestBits)) - 1), rest - kAnsRestBits);
      }
      for (uint32_t lane = lanes; lane-- > 0;) {
        const uint32_t first = firstRest(restBits(tokenOf(own[lane])));
        if (first > 0) putRest(lane, own[lane] & ((1u << first) - 1), first);
      }
    }
    if (isConstant) continue;
    if (any < kDirectTokens) {
      at = putStep(model, own, lanes, at);
      continue;
    }
    uint32_t tokens[kAnsLanes];
    for (uint32_t lane = 0; lane < lanes; ++lane) tokens[lane] = tokenOf(own[lane]);
    at = putStep(model, tokens, lanes, at);
  }
  first_ -= static_cast<size_t>(before - at);
}

void AnsWriter::finish(std::vector<std::byte>& out) const {
  const size_t words = words_.size() - first_, start = out.size();
  if (words == 0 && std::ranges::all_of(states_, [](uint32_t state) { return state == kAnsLow; })) return;
  out.resize(start + kAnsStateBytes + kWord * words);
  std::byte* at = out.data() + start;
  for (const uint32_t state : states_) {
    storeLittle(at, state);
    at += sizeof state;
  }
  for (size_t i = 0; i < words; ++i) storeLittle(at + kWord * i, words_[first_ + i]);
}

AnsReader::AnsReader(std::span<const std::byte> bytes) : hasStream_(!bytes.empty()) {
  if (!hasStream_) return;
  ByteReader reader(bytes);
  for (uint32_t& state : states_) state = reader.take<uint32_t>();
  isBad_ = reader.ranOut() || std::ranges::any_of(states_, ansWants) || reader.left() % kWord != 0;
  words_ = reader.take(reader.left());
}

/// Gives words to the first lanes that want some.
inline void AnsReader::refill(uint32_t lanes) {
  uint32_t* const states = states_.data();
  if (words_.size() - next_ >= kWord * kAnsLanes) {
    const std::byte* at = words_.data() + next_;
    for (uint32_t lane = 0; lane < lanes; ++lane) {
      const uint32_t state = states[lane], filled = state << 16 | loadLittle<uint16_t>(at);
      const bool wants = ansWants(state);
      states[lane] = wants ? filled : state;
      at += wants ? kWord : 0;
    }
    next_ = static_cast<size_t>(at - words_.data());
    return;
  }
  for (uint32_t lane = 0; lane < lanes; ++lane) {
    if (!ansWants(states[lane])) continue;
    const bool isThere = next_ + kWord <= words_.size();
    states[lane] = states[lane] << 16 | (isThere ? loadLittle<uint16_t>(words_.data() + next_) : 0u);
    if (isThere)
      next_ += kWord;
    else
      isBad_ = true;
  }
}

template <class T>
void AnsReader::takeSymbols(const AnsReaderModel& model, std::span<T> symbols) {
  const uint32_t* const slots = model.slots.data();
  T* const symbol = symbols.data();
  const uint32_t steps = stepsOf(symbols.size());
  for (uint32_t step = 0; step < steps; ++step) {
    const uint32_t lanes = lanesOf(symbols.size(), step);
    uint32_t* const states = states_.data();
    T* const own = symbol + size_t{step} * kAnsLanes;
    uint32_t any = 0;
#if defined(__AVX512F__)
    if (lanes == kAnsLanes && words_.size() - next_ >= kWord * kAnsLanes) {
      const std::byte* at = words_.data() + next_;
      for (uint32_t half = 0; half < kAnsLanes; half += 16) {
        __m512i state = _mm512_loadu_si512(states + half);
        const __m512i taken = take16(slots, state, at);
        _mm512_storeu_si512(states + half, state);
        storeSymbols(own + half, taken);
        if constexpr (sizeof(T) > 1) any |= _mm512_cmpge_epu32_mask(taken, _mm512_set1_epi32(kDirectTokens)) != 0 ? kDirectTokens : 0;
      }
      next_ = static_cast<size_t>(at - words_.data());
      if constexpr (sizeof(T) > 1)
        if (any >= kDirectTokens) takeRests(symbols.subspan(size_t{step} * kAnsLanes, lanes));
      continue;
    }
#endif
    for (uint32_t lane = 0; lane < lanes; ++lane) {
      const uint32_t state = states[lane], slot = slots[state & (kAnsScale - 1)];
      own[lane] = static_cast<T>(ansSymbolOf(slot));
      any |= own[lane];
      states[lane] = ansTake(state, slot);
    }
    refill(lanes);
    if constexpr (sizeof(T) > 1)
      if (any >= kDirectTokens) takeRests(symbols.subspan(size_t{step} * kAnsLanes, lanes));
  }
}

/// Makes numbers of a step's tokens.
void AnsReader::takeRests(std::span<uint32_t> numbers) {
  const auto lanes = static_cast<uint32_t>(numbers.size());
  std::array<uint32_t, kAnsLanes> rests{};
  const auto takePart = [&](uint32_t shift) {
    for (uint32_t lane = 0; lane < lanes; ++lane) {
      const uint32_t bits = restBits(numbers[lane]), count = bits > shift ? firstRest(bits - shift) : 0;
      if (count == 0) continue;
      rests[lane] |= (states_[lane] & ((1u << count) - 1)) << shift;
      states_[lane] >>= count;
    }
    refill(lanes);
  };
  takePart(0);
  takePart(kAnsRestBits);
  for (uint32_t lane = 0; lane < lanes; ++lane) numbers[lane] = valueOf(numbers[lane], rests[lane]);
}

void AnsReader::takeBytes(const AnsReaderModel& model, std::span<uint8_t> symbols) {
  if (symbols.empty()) return;
  if (model.slots.empty()) {
    isBad_ |= model.model.isEmpty();
    std::ranges::fill(symbols, model.model.constant());
    return;
  }
  isBad_ |= !hasStream_;
  if (hasStream_)
    takeSymbols(model, symbols);
  else
    std::ranges::fill(symbols, uint8_t{0});
}

void AnsReader::takeNumbers(const AnsReaderModel& model, std::span<uint32_t> numbers) {
  if (numbers.empty()) return;
  if (!model.slots.empty() && hasStream_) return takeSymbols(model, numbers);
  isBad_ |= model.model.isEmpty() || !model.slots.empty();
  const uint32_t token = model.slots.empty() ? model.model.constant() : 0;
  std::ranges::fill(numbers, token);
  if (restBits(token) == 0) return;
  isBad_ |= !hasStream_;
  if (hasStream_)
    for (size_t begin = 0; begin < numbers.size(); begin += kAnsLanes) takeRests(numbers.subspan(begin, std::min<size_t>(kAnsLanes, numbers.size() - begin)));
  else
    std::ranges::fill(numbers, 0u);
}

bool AnsReader::isSound() const {
  return !isBad_ && next_ == words_.size() && (!hasStream_ || std::ranges::all_of(states_, [](uint32_t state) { return state == kAnsLow; }));
}

}  // namespace warpscope
