// States side by side. Loops read and write through locals only: what they write cannot be what they read then.
// See ans_lanes.h.
#include "render/codec/tiled/ans_lanes.h"

#include <algorithm>
#include <bit>

#include "render/codec/tiled/ans_vectors.h"
#include "render/codec/tokens.h"

namespace warpscope {
namespace {

constexpr size_t kWord = sizeof(uint16_t);

uint32_t stepsOf(size_t symbols) { return static_cast<uint32_t>((symbols + kAnsLanes - 1) / kAnsLanes); }
uint32_t lanesOf(size_t symbols, uint32_t step) { return static_cast<uint32_t>(std::min<size_t>(symbols - size_t{step} * kAnsLanes, kAnsLanes)); }

/// Words in front of those that there are which vectors may write to besides.
constexpr size_t kSpareWords = 16;

#ifdef WARPSCOPE_HAS_ANS_VECTORS
static_assert(kSpareWords >= kAnsVectorLanes);

/// Calls `f` with the first of each vector's lanes.
template <class F>
void forEachVector(const F& f) {
  for (uint32_t lane = 0; lane < kAnsLanes; lane += kAnsVectorLanes) f(lane);
}
template <class F>
void forEachVectorFromTheEnd(const F& f) {
  for (uint32_t lane = kAnsLanes; lane > 0;) f(lane -= kAnsVectorLanes);
}
#endif

/// The bits of a number behind its token that a state takes first, and those that are left.
uint32_t firstRest(uint32_t bits) { return std::min(bits, kAnsRestBits); }

}  // namespace

void findTokens(const uint32_t* numbers, uint32_t lanes, uint32_t* tokens) {
#ifdef WARPSCOPE_HAS_ANS_VECTORS
  if (lanes == kAnsLanes)
    return forEachVector([&](uint32_t lane) {
      const AnsVector own = loadedLanes(numbers + lane);
      storeLanes(tokensOf(own, restsOf(own)), tokens + lane);
    });
#endif
  for (uint32_t lane = 0; lane < lanes; ++lane) tokens[lane] = tokenOf(numbers[lane]);
}

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
  if (first_ < words + kSpareWords) {
    const size_t kept = words_.size() - first_, more = words + kSpareWords + words_.size();
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
#ifdef WARPSCOPE_HAS_ANS_VECTORS
  if (lanes == kAnsLanes) {
    forEachVectorFromTheEnd([&](uint32_t lane) { at = putLanes(model, symbols + lane, states + lane, at); });
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

/// Puts what the tokens of a step's numbers leave open. `any`: all bits of all of these.
uint16_t* AnsWriter::putRests(const uint32_t* numbers, uint32_t lanes, uint32_t any, uint16_t* at) {
  uint32_t* const states = states_.data();
  for (const uint32_t shift : {kAnsRestBits, 0u}) {
    if (any >> shift < kDirectTokens >> 2) continue;  // no rest, which leaves out the two highest bits, goes so far
#ifdef WARPSCOPE_HAS_ANS_VECTORS
    if (lanes == kAnsLanes) {
      forEachVectorFromTheEnd([&](uint32_t lane) { at = putRestLanes(numbers + lane, shift, states + lane, at); });
      continue;
    }
#endif
    for (uint32_t lane = lanes; lane-- > 0;) {
      const uint32_t rest = restBits(tokenOf(numbers[lane])), count = firstRest(rest > shift ? rest - shift : 0);
      if (count == 0) continue;
      uint16_t word;
      if (ansGivesForBits(states[lane], count, word)) *--at = word;
      states[lane] = ansPutBits(states[lane], numbers[lane] >> shift & ((1u << count) - 1), count);
    }
  }
  return at;
}

void AnsWriter::putNumbers(const AnsWriterModel& model, std::span<const uint32_t> numbers) {
  constexpr size_t kMostWords = 3;  // of a token and both parts of its rest
  uint16_t* at = reserve(kMostWords * numbers.size());
  const uint16_t* const before = at;
  const uint32_t* const number = numbers.data();
  const bool isConstant = model.model.isConstant();
  for (uint32_t step = stepsOf(numbers.size()); step-- > 0;) {
    const uint32_t lanes = lanesOf(numbers.size(), step);
    const uint32_t* const own = number + size_t{step} * kAnsLanes;
    uint32_t any = 0;
    for (uint32_t lane = 0; lane < lanes; ++lane) any |= own[lane];
    if (any >= kDirectTokens) at = putRests(own, lanes, any, at);
    if (isConstant) continue;
    if (any < kDirectTokens) {
      at = putStep(model, own, lanes, at);
      continue;
    }
    alignas(64) uint32_t tokens[kAnsLanes];
    findTokens(own, lanes, tokens);
    at = putStep(model, tokens, lanes, at);
  }
  first_ -= static_cast<size_t>(before - at);
}

void AnsWriter::finish(ByteVector& out) const {
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
  if (hasWordsForAll()) {
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
#ifdef WARPSCOPE_HAS_ANS_VECTORS
    if (lanes == kAnsLanes && hasWordsForAll()) {
      const std::byte* at = words_.data() + next_;
      bool hasRests = false;
      forEachVector([&](uint32_t lane) { hasRests |= takeLanes(slots, states + lane, at, own + lane); });
      next_ = static_cast<size_t>(at - words_.data());
      if constexpr (sizeof(T) > 1)
        if (hasRests) takeRests(symbols.subspan(size_t{step} * kAnsLanes, lanes));
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
  alignas(64) std::array<uint32_t, kAnsLanes> rests{};
  const auto takePart = [&](uint32_t shift) {
#ifdef WARPSCOPE_HAS_ANS_VECTORS
    if (lanes == kAnsLanes && hasWordsForAll()) {
      const std::byte* at = words_.data() + next_;
      forEachVector([&](uint32_t lane) { takeRestLanes(numbers.data() + lane, shift, states_.data() + lane, at, rests.data() + lane); });
      next_ = static_cast<size_t>(at - words_.data());
      return;
    }
#endif
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
#ifdef WARPSCOPE_HAS_ANS_VECTORS
  if (lanes == kAnsLanes) return forEachVector([&](uint32_t lane) { makeNumbers(numbers.data() + lane, rests.data() + lane); });
#endif
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
