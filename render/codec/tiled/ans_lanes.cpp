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

/// Words in front of those that there are which vectors may write to besides.
constexpr size_t kSpareWords = 16;

/// The bits of a number behind its token that a state takes first, and those that are left.
uint32_t firstRest(uint32_t bits) { return std::min(bits, kAnsRestBits); }

/// States one after the other: those of the first lanes.
class SingleStates {
 public:
  explicit SingleStates(std::array<uint32_t, kAnsLanes>& states, uint32_t lanes = kAnsLanes) : states_(states), lanes_(lanes) {}

  /// Puts a symbol a lane. Returns where words begin then.
  uint16_t* put(const AnsWriterModel& model, const uint8_t* symbols, uint16_t* at) {
    for (uint32_t lane = lanes_; lane-- > 0;) {
      const AnsShare share = model.model.share(symbols[lane]);
      uint16_t word;
      if (ansGives(states_[lane], share, word)) *--at = word;
      states_[lane] = ansPut(states_[lane], share);
    }
    return at;
  }
  /// The same of what numbers' tokens leave open, as much of it from bit `shift` on as a state takes at once.
  uint16_t* putRests(const uint32_t* numbers, uint32_t shift, uint16_t* at) {
    for (uint32_t lane = lanes_; lane-- > 0;) {
      const uint32_t rest = restBits(tokenOf(numbers[lane])), count = firstRest(rest > shift ? rest - shift : 0);
      if (count == 0) continue;
      uint16_t word;
      if (ansGivesForBits(states_[lane], count, word)) *--at = word;
      states_[lane] = ansPutBits(states_[lane], numbers[lane] >> shift & ((1u << count) - 1), count);
    }
    return at;
  }

 private:
  std::array<uint32_t, kAnsLanes>& states_;
  uint32_t lanes_;
};
#ifdef WARPSCOPE_HAS_ANS_VECTORS
static_assert(kSpareWords >= kAnsVectorLanes);
using WholeStates = AnsStates;
#else
using WholeStates = SingleStates;
#endif

/// What the tokens of a step's numbers leave open.
template <class States>
uint16_t* putRests(States& states, const uint32_t* numbers, uint32_t lanes, uint16_t* at) {
  uint32_t any = 0;
  for (uint32_t lane = 0; lane < lanes; ++lane) any |= numbers[lane];
  for (const uint32_t shift : {kAnsRestBits, 0u})
    if (any >> shift >= kDirectTokens >> 2) at = states.putRests(numbers, shift, at);  // else no rest, which leaves out the two highest bits, goes so far
  return at;
}

/// step(states, number of the first symbol, how many) of `size` symbols, from the end.
template <class Step>
void forEachStepFromTheEnd(std::array<uint32_t, kAnsLanes>& states, size_t size, const Step& step) {
  const auto few = static_cast<uint32_t>(size % kAnsLanes);
  size_t at = size - few;
  if (few > 0) {
    SingleStates first(states, few);
    step(first, at, few);
  }
  WholeStates all(states);
  while (at > 0) step(all, at -= kAnsLanes, kAnsLanes);
}

#ifdef WARPSCOPE_HAS_ANS_VECTORS
/// The words of a stream for vectors, which read some more than they take: behind the last there are zeros.
class WordsAhead {
 public:
  WordsAhead(std::span<const std::byte> words, size_t next) : at_(words.data() + next), end_(words.data() + words.size()), left_(words.size()) {}
  WordsAhead(const WordsAhead&) = delete;
  WordsAhead& operator=(const WordsAhead&) = delete;

  /// As many as there are lanes, and more behind them.
  const std::byte* next() {
    if (!isTail_ && static_cast<size_t>(end_ - at_) < kMost) startTail();
    return at_;
  }
  void moveTo(const std::byte* at) {
    at_ = at;
    if (at_ <= end_) return;
    ranOut_ = true;
    at_ = end_;
  }
  bool ranOut() const { return ranOut_; }
  /// Of the stream.
  size_t place() const { return left_ - static_cast<size_t>(end_ - at_); }

 private:
  static constexpr size_t kMost = kAnsLanes * kWord;

  void startTail() {
    const auto size = static_cast<size_t>(end_ - at_);
    std::copy(at_, end_, tail_.begin());
    std::fill(tail_.begin() + static_cast<std::ptrdiff_t>(size), tail_.end(), std::byte{0});
    at_ = tail_.data();
    end_ = at_ + size;
    isTail_ = true;
  }

  const std::byte* at_;
  const std::byte* end_;
  size_t left_;
  std::array<std::byte, 2 * kMost + kAnsVectorLanes * kWord> tail_;
  bool isTail_ = false, ranOut_ = false;
};
#endif

}  // namespace

bool findTokens(std::span<const uint32_t> numbers, std::span<uint8_t> tokens) {
  const uint32_t* const number = numbers.data();
  uint8_t* const token = tokens.data();
  size_t i = 0;
  bool isOpen = false;
#ifdef WARPSCOPE_HAS_ANS_VECTORS
  for (; i + kAnsVectorLanes <= numbers.size(); i += kAnsVectorLanes) {
    const AnsVector own = loadedLanes(number + i);
    const bool isOwnOpen = bitsOf(areLess(AnsVector{} + (kDirectTokens - 1), own)) != 0;
    storeLanes(isOwnOpen ? tokensOf(own, restsOf(own)) : own, token + i);
    isOpen |= isOwnOpen;
  }
#endif
  for (; i < numbers.size(); ++i) {
    token[i] = static_cast<uint8_t>(tokenOf(number[i]));
    isOpen |= number[i] >= kDirectTokens;
  }
  return isOpen;
}

AnsWriterModel::AnsWriterModel(const AnsModel& theModel) : model(theModel) {
  for (uint32_t s = 0; s < kAnsSymbols; ++s) {
    const AnsWriterShare share = AnsWriterShare::of(model.share(s));
    multipliers[s] = share.multiplier;
    parts[s] = share.parts;
  }
  const auto frequencies = model.frequencies();
  uint32_t sum = 0, most = 0;
  for (uint32_t s = 0; s < kAnsSymbols + kNear; ++s) {  // sum: of the kNear symbols up to s
    sum += frequencies[s % kAnsSymbols];
    if (s < kNear) continue;
    sum -= frequencies[s - kNear];
    if (sum <= most) continue;
    most = sum;
    nearest = static_cast<uint8_t>(s - kNear + 1);
  }
  for (uint32_t i = 0; i < kNear; ++i) {
    nearMultipliers[i] = multipliers[(nearest + i) % kAnsSymbols];
    nearParts[i] = parts[(nearest + i) % kAnsSymbols];
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

void AnsWriter::putBytes(const AnsWriterModel& model, std::span<const uint8_t> symbols) {
  if (model.model.isConstant()) return;
  uint16_t* at = reserve(symbols.size());
  const uint16_t* const before = at;
  forEachStepFromTheEnd(states_, symbols.size(), [&](auto& states, size_t first, uint32_t) { at = states.put(model, symbols.data() + first, at); });
  first_ -= static_cast<size_t>(before - at);
}

void AnsWriter::putNumbers(const AnsWriterModel& model, std::span<const uint32_t> numbers, std::span<const uint8_t> tokens) {
  constexpr size_t kMostWords = 3;  // of a token and both parts of its rest
  uint16_t* at = reserve(kMostWords * numbers.size());
  const uint16_t* const before = at;
  const bool isConstant = model.model.isConstant();
  forEachStepFromTheEnd(states_, numbers.size(), [&](auto& states, size_t first, uint32_t lanes) {
    uint8_t any = 0;
    for (uint32_t lane = 0; lane < lanes; ++lane) any |= tokens[first + lane];
    if (any >= kDirectTokens) at = putRests(states, numbers.data() + first, lanes, at);
    if (!isConstant) at = states.put(model, tokens.data() + first, at);
  });
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
  words_ = reader.take(reader.left() / kWord * kWord);
}

/// Gives words to the first lanes that want some.
inline void AnsReader::refill(uint32_t lanes) {
  uint32_t* const states = states_.data();
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

#ifdef WARPSCOPE_HAS_ANS_VECTORS
/// A reader in registers, for as long as this is there.
class AnsReader::InVectors {
 public:
  explicit InVectors(AnsReader& reader) : reader_(reader), states_(reader.states_), words_(reader.words_, reader.next_) {}
  InVectors(const InVectors&) = delete;
  InVectors& operator=(const InVectors&) = delete;
  ~InVectors() {
    reader_.isBad_ |= words_.ranOut();
    reader_.next_ = words_.place();
  }

  /// Symbols of all lanes: bytes, or numbers, with what their tokens leave open.
  template <class T>
  void take(const uint32_t* slots, T* symbols) {
    bool hasRests = false;
    const std::byte* at = words_.next();
    states_.forEach([&](uint32_t lane, AnsVector& own) { hasRests |= takeLanes(slots, own, at, symbols + lane); });
    words_.moveTo(at);
    if constexpr (sizeof(T) > 1)
      if (hasRests) takeRests(symbols);
  }

 private:
  void takeRests(uint32_t* numbers) {
    alignas(64) uint32_t rests[kAnsLanes] = {};
    for (const uint32_t shift : {0u, kAnsRestBits}) {
      const std::byte* at = words_.next();
      states_.forEach([&](uint32_t lane, AnsVector& own) { takeRestLanes(numbers + lane, shift, own, at, rests + lane); });
      words_.moveTo(at);
    }
    states_.forEach([&](uint32_t lane, AnsVector&) { makeNumbers(numbers + lane, rests + lane); });
  }

  AnsReader& reader_;
  AnsStates states_;
  WordsAhead words_;
};
#endif

template <class T>
void AnsReader::takeSymbols(const AnsReaderModel& model, std::span<T> symbols) {
  const uint32_t* const slots = model.slots.data();
  size_t done = 0;
#ifdef WARPSCOPE_HAS_ANS_VECTORS
  {
    InVectors vectors(*this);
    for (; done + kAnsLanes <= symbols.size(); done += kAnsLanes) vectors.take(slots, symbols.data() + done);
  }
#endif
  for (; done < symbols.size(); done += kAnsLanes) {
    const std::span<T> own = symbols.subspan(done, std::min<size_t>(kAnsLanes, symbols.size() - done));
    uint32_t any = 0;
    for (size_t lane = 0; lane < own.size(); ++lane) {
      const uint32_t state = states_[lane], slot = slots[state & (kAnsScale - 1)];
      own[lane] = static_cast<T>(ansSymbolOf(slot));
      any |= own[lane];
      states_[lane] = ansTake(state, slot);
    }
    refill(static_cast<uint32_t>(own.size()));
    if constexpr (sizeof(T) > 1)
      if (any >= kDirectTokens) takeRests(own);
  }
}

/// What both have, as far as that is worth it. Returns how many of each.
template <class T>
size_t AnsReader::takeSymbols([[maybe_unused]] const AnsReaderModel& model, [[maybe_unused]] AnsReader& first, [[maybe_unused]] std::span<T> symbols,
                              [[maybe_unused]] AnsReader& second, [[maybe_unused]] std::span<T> secondSymbols) {
  size_t done = 0;
#ifdef WARPSCOPE_HAS_ANS_VECTORS
  if (model.slots.empty() || !first.hasStream_ || !second.hasStream_) return done;
  const uint32_t* const slots = model.slots.data();
  InVectors vectors(first), secondVectors(second);
  for (const size_t both = std::min(symbols.size(), secondSymbols.size()); done + kAnsLanes <= both; done += kAnsLanes) {
    vectors.take(slots, symbols.data() + done);
    secondVectors.take(slots, secondSymbols.data() + done);
  }
#endif
  return done;
}

/// Makes numbers of a step's tokens.
void AnsReader::takeRests(std::span<uint32_t> numbers) {
  const auto lanes = static_cast<uint32_t>(numbers.size());
  std::array<uint32_t, kAnsLanes> rests{};
  for (const uint32_t shift : {0u, kAnsRestBits}) {
    for (uint32_t lane = 0; lane < lanes; ++lane) {
      const uint32_t bits = restBits(numbers[lane]), count = bits > shift ? firstRest(bits - shift) : 0;
      if (count == 0) continue;
      rests[lane] |= (states_[lane] & ((1u << count) - 1)) << shift;
      states_[lane] >>= count;
    }
    refill(lanes);
  }
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

void AnsReader::takeBytes(const AnsReaderModel& model, AnsReader& first, std::span<uint8_t> symbols, AnsReader& second, std::span<uint8_t> secondSymbols) {
  const size_t done = takeSymbols(model, first, symbols, second, secondSymbols);
  first.takeBytes(model, symbols.subspan(done));
  second.takeBytes(model, secondSymbols.subspan(done));
}

void AnsReader::takeNumbers(const AnsReaderModel& model, AnsReader& first, std::span<uint32_t> numbers, AnsReader& second, std::span<uint32_t> secondNumbers) {
  const size_t done = takeSymbols(model, first, numbers, second, secondNumbers);
  first.takeNumbers(model, numbers.subspan(done));
  second.takeNumbers(model, secondNumbers.subspan(done));
}

bool AnsReader::isSound() const {
  return !isBad_ && next_ == words_.size() && (!hasStream_ || std::ranges::all_of(states_, [](uint32_t state) { return state == kAnsLow; }));
}

}  // namespace warpscope
