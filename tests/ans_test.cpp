// Models and streams of the format `tiled`: against one state after the other.
// Mirrors render/codec/tiled/ans.h, ans_model.h, ans_lanes.h.
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <random>
#include <span>
#include <vector>

#include "render/codec/tiled/ans_lanes.h"
#include "render/codec/tokens.h"

namespace warpscope {
namespace {

using Counts = std::array<uint32_t, kAnsSymbols>;

uint32_t sumOf(const AnsModel& model) {
  const auto frequencies = model.frequencies();
  return std::accumulate(frequencies.begin(), frequencies.end(), 0u);
}

bool isSame(const AnsModel& a, const AnsModel& b) { return std::ranges::equal(a.frequencies(), b.frequencies()); }

/// `symbols` of `most` kinds, some far more frequent than others.
std::vector<uint8_t> randomSymbols(std::mt19937& random, size_t count, uint32_t most) {
  std::geometric_distribution<uint32_t> mostlyFew(0.3);
  std::vector<uint8_t> symbols(count);
  for (uint8_t& symbol : symbols) symbol = static_cast<uint8_t>(random() % 4 == 0 ? random() % most : mostlyFew(random) % most);
  return symbols;
}

AnsModel modelOf(std::span<const uint8_t> symbols) {
  Counts counts{};
  for (const uint8_t symbol : symbols) ++counts[symbol];
  return AnsModel::ofCounts(counts);
}

AnsModel modelOfNumbers(std::span<const uint32_t> numbers) {
  Counts counts{};
  for (const uint32_t number : numbers) ++counts[tokenOf(number)];
  return AnsModel::ofCounts(counts);
}

TEST(AnsModel, FrequenciesAddUpAndEverySymbolThatOccursHasOne) {
  std::mt19937 random(3);
  for (int round = 0; round < 300; ++round) {
    Counts counts{};
    const uint32_t kinds = 1 + random() % kAnsSymbols;
    for (uint32_t i = 0; i < kinds; ++i) counts[random() % kAnsSymbols] = round % 3 == 0 ? 1 : 1 + (random() >> random() % 32);
    if (round % 5 == 0) counts[random() % kAnsSymbols] = ~0u;  // nothing is left for the others
    const AnsModel model = AnsModel::ofCounts(counts);
    ASSERT_EQ(sumOf(model), kAnsScale);
    for (uint32_t s = 0; s < kAnsSymbols; ++s) ASSERT_EQ(model.share(s).frequency > 0, counts[s] > 0) << s;
    ByteVector bytes;
    model.append(bytes);
    ASSERT_LE(bytes.size(), AnsModel::kMostBytes);
    ByteReader reader(bytes);
    AnsModel back;
    ASSERT_TRUE(back.take(reader));
    ASSERT_EQ(reader.left(), 0u);
    ASSERT_TRUE(isSame(back, model));
  }
}

TEST(AnsModel, OfNothingIsEmptyAndOfOneSymbolConstant) {
  AnsModel model = AnsModel::ofCounts(Counts{});
  EXPECT_TRUE(model.isEmpty());
  EXPECT_FALSE(model.isConstant());
  Counts one{};
  one[77] = 5;
  model = AnsModel::ofCounts(one);
  EXPECT_TRUE(model.isConstant());
  EXPECT_EQ(model.constant(), 77);
  EXPECT_TRUE(model.slots().empty());
}

TEST(AnsModel, WhatDoesNotAddUpIsNone) {
  for (const std::vector<int>& numbers : {std::vector<int>{0, 127}, {1, 100, 100}, {0, 0x90, 1}, {0, 0xff, 0xff}, {3, 1, 1}, {}, {255}}) {
    ByteVector bytes;
    for (const int number : numbers) bytes.push_back(static_cast<std::byte>(number));
    ByteReader reader(bytes);
    AnsModel model;
    EXPECT_FALSE(model.take(reader)) << numbers.size();
  }
}

std::vector<uint8_t> tokensOf(std::span<const uint32_t> numbers) {
  std::vector<uint8_t> tokens(numbers.size());
  const bool isOpen = findTokens(numbers, tokens);
  EXPECT_EQ(isOpen, std::ranges::any_of(numbers, [](uint32_t number) { return number >= kDirectTokens; }));
  for (size_t i = 0; i < numbers.size(); ++i) EXPECT_EQ(tokens[i], tokenOf(numbers[i])) << i << " of " << numbers.size();
  return tokens;
}

TEST(FindTokens, TellsOfAnyNumberThatItLeavesOpen) {
  for (size_t size = 0; size < 70; ++size) {
    std::vector<uint32_t> numbers(size, 3);
    tokensOf(numbers);
    for (uint32_t& number : numbers) {
      for (const uint32_t open : {kDirectTokens - 1, kDirectTokens, ~0u}) {
        number = open;
        tokensOf(numbers);
      }
      number = 3;
    }
  }
}

RC_GTEST_PROP(AnsLanes, SymbolsAndNumbersComeBackInTheirOrder, ()) {
  std::mt19937 random(*rc::gen::arbitrary<uint32_t>());
  const auto size = *rc::gen::inRange<size_t>(0, 700);
  const auto bits = *rc::gen::inRange<uint32_t>(0, 33);
  const std::vector<uint8_t> first = randomSymbols(random, size, 1 + random() % kAnsSymbols), second = randomSymbols(random, random() % 400, 3);
  std::vector<uint32_t> numbers(random() % 500);
  for (uint32_t& number : numbers) number = bits == 0 ? 900u : static_cast<uint32_t>(uint64_t{random()} & ((uint64_t{1} << random() % (bits + 1)) - 1));
  const AnsModel models[] = {modelOf(first), modelOfNumbers(numbers), modelOf(second)};
  AnsWriter writer;
  ByteVector stream;
  for (int again = 0; again < 2; ++again) {  // a writer is used for many streams
    stream.clear();
    writer.begin();
    if (!second.empty()) writer.putBytes(AnsWriterModel(models[2]), second);
    if (!numbers.empty()) writer.putNumbers(AnsWriterModel(models[1]), numbers, tokensOf(numbers));
    if (!first.empty()) writer.putBytes(AnsWriterModel(models[0]), first);
    writer.finish(stream);
  }
  AnsReader reader(stream);
  std::vector<uint8_t> firstBack(first.size()), secondBack(second.size());
  std::vector<uint32_t> numbersBack(numbers.size());
  reader.takeBytes(AnsReaderModel(models[0]), firstBack);
  reader.takeNumbers(AnsReaderModel(models[1]), numbersBack);
  reader.takeBytes(AnsReaderModel(models[2]), secondBack);
  RC_ASSERT(firstBack == first);
  RC_ASSERT(numbersBack == numbers);
  RC_ASSERT(secondBack == second);
  RC_ASSERT(reader.isSound());
}

/// Every frequency, at states where a quotient changes and at any others.
TEST(AnsWriterShare, DividesExactly) {
  std::mt19937 random(9);
  for (uint32_t frequency = 1; frequency < kAnsScale; ++frequency) {
    const AnsShare share{static_cast<uint32_t>(random() % (kAnsScale - frequency + 1)), frequency};
    const AnsWriterShare own = AnsWriterShare::of(share);
    ASSERT_EQ(own.frequency(), frequency);
    const uint32_t below = frequency << (32 - kAnsBits);  // states that take the symbol
    const auto expectSame = [&](uint32_t state) {
      uint16_t word;
      uint32_t left = state;
      ASSERT_EQ(own.gives(state), ansGives(left, share, word)) << frequency << ", " << state;
      if (left < below) ASSERT_EQ(own.put(left), ansPut(left, share)) << frequency << ", " << left;
    };
    for (const uint32_t state : {kAnsLow, below - 1, below, below + 1, ~0u, ~0u - 1}) expectSame(state);
    for (int round = 0; round < 200; ++round) {
      const uint32_t quotient = kAnsLow / frequency + 1 + static_cast<uint32_t>(random()) % ((1u << (32 - kAnsBits)) - kAnsLow / frequency - 1);
      expectSame(std::max(kAnsLow, quotient * frequency - 1));
      expectSame(std::max(kAnsLow, quotient * frequency));
      expectSame(std::max(kAnsLow, static_cast<uint32_t>(random())));
    }
  }
}

TEST(AnsLanes, TakeAboutTheBitsThatTheirModelSays) {
  std::mt19937 random(9);
  std::vector<uint8_t> symbols(100000);
  for (uint8_t& symbol : symbols) symbol = random() % 50 == 0 ? 1 : 0;
  const AnsModel model = modelOf(symbols);
  double bits = 0.0;
  for (const uint8_t symbol : symbols) bits -= std::log2(static_cast<double>(model.share(symbol).frequency) / kAnsScale);
  AnsWriter writer;
  writer.begin();
  writer.putBytes(AnsWriterModel(model), symbols);
  ByteVector stream;
  writer.finish(stream);
  EXPECT_NEAR(static_cast<double>(stream.size() - kAnsStateBytes), bits / 8.0, 0.002 * bits / 8.0 + 2.0 * kAnsLanes);
}

TEST(AnsLanes, StreamsCutShortOrChangedAreNotSound) {
  std::mt19937 random(21);
  const std::vector<uint8_t> symbols = randomSymbols(random, 2000, 40);
  const AnsModel model = modelOf(symbols);
  AnsWriter writer;
  writer.begin();
  writer.putBytes(AnsWriterModel(model), symbols);
  ByteVector stream;
  writer.finish(stream);
  std::vector<uint8_t> back(symbols.size());
  for (size_t length = 0; length < stream.size(); ++length) {
    AnsReader reader(std::span<const std::byte>(stream.data(), length));
    reader.takeBytes(AnsReaderModel(model), back);
    EXPECT_FALSE(reader.isSound()) << length;
  }
  size_t unnoticed = 0;
  for (size_t i = 0; i < stream.size(); ++i) {
    ByteVector changed = stream;
    changed[i] ^= std::byte{0x41};
    AnsReader reader(changed);
    reader.takeBytes(AnsReaderModel(model), back);
    unnoticed += reader.isSound() ? 1 : 0;
  }
  EXPECT_EQ(unnoticed, 0u);  // states end where writers began
}

/// ans.h, one state after the other.
class PlainWriter {
 public:
  void putBytes(const AnsModel& model, std::span<const uint8_t> symbols) {
    if (model.isConstant()) return;
    for (size_t i = symbols.size(); i-- > 0;) put(model, i % kAnsLanes, symbols[i]);
  }
  void putNumbers(const AnsModel& model, std::span<const uint32_t> numbers) {
    for (size_t step = (numbers.size() + kAnsLanes - 1) / kAnsLanes; step-- > 0;) {
      const auto own = numbers.subspan(step * kAnsLanes, std::min<size_t>(kAnsLanes, numbers.size() - step * kAnsLanes));
      for (const uint32_t shift : {kAnsRestBits, 0u})
        for (size_t lane = own.size(); lane-- > 0;) {
          const uint32_t rest = restBits(tokenOf(own[lane])), count = std::min(rest > shift ? rest - shift : 0, kAnsRestBits);
          if (count == 0) continue;
          uint16_t word;
          if (ansGivesForBits(states_[lane], count, word)) words_.push_back(word);
          states_[lane] = ansPutBits(states_[lane], own[lane] >> shift & ((1u << count) - 1), count);
        }
      if (!model.isConstant())
        for (size_t lane = own.size(); lane-- > 0;) put(model, lane, tokenOf(own[lane]));
    }
  }
  ByteVector finish() const {
    ByteVector out;
    if (words_.empty() && std::ranges::all_of(states_, [](uint32_t state) { return state == kAnsLow; })) return out;
    for (const uint32_t state : states_) appendLittle(out, state);
    for (size_t i = words_.size(); i-- > 0;) appendLittle(out, words_[i]);
    return out;
  }

 private:
  void put(const AnsModel& model, size_t lane, uint32_t symbol) {
    uint16_t word;
    if (ansGives(states_[lane], model.share(symbol), word)) words_.push_back(word);
    states_[lane] = ansPut(states_[lane], model.share(symbol));
  }

  std::vector<uint32_t> states_ = std::vector<uint32_t>(kAnsLanes, kAnsLow);
  std::vector<uint16_t> words_;  // the last one first
};

/// The same. Behind the end there are zeros, and the stream is not sound.
class PlainReader {
 public:
  explicit PlainReader(std::span<const std::byte> stream) : reader_(stream) {
    for (uint32_t& state : states_) state = reader_.take<uint32_t>();
  }

  std::vector<uint32_t> take(const AnsModel& model, size_t count, bool areNumbers) {
    const std::vector<uint32_t> slots = model.slots();
    std::vector<uint32_t> values(count);
    for (size_t begin = 0; begin < count; begin += kAnsLanes) {
      const auto own = std::span(values).subspan(begin, std::min<size_t>(kAnsLanes, count - begin));
      for (size_t lane = 0; lane < own.size(); ++lane) {
        const uint32_t slot = slots[states_[lane] & (kAnsScale - 1)];
        own[lane] = ansSymbolOf(slot);
        states_[lane] = ansTake(states_[lane], slot);
      }
      refill(own.size());
      if (!areNumbers || std::ranges::all_of(own, [](uint32_t token) { return token < kDirectTokens; })) continue;
      std::array<uint32_t, kAnsLanes> rests{};
      for (const uint32_t shift : {0u, kAnsRestBits}) {
        for (size_t lane = 0; lane < own.size(); ++lane) {
          const uint32_t rest = restBits(own[lane]), bits = std::min(rest > shift ? rest - shift : 0, kAnsRestBits);
          rests[lane] |= (states_[lane] & ((1u << bits) - 1)) << shift;
          states_[lane] >>= bits;
        }
        refill(own.size());
      }
      for (size_t lane = 0; lane < own.size(); ++lane) own[lane] = valueOf(own[lane], rests[lane]);
    }
    return values;
  }
  bool isSound() const {
    return !isBad_ && reader_.left() == 0 && std::ranges::all_of(states_, [](uint32_t state) { return state == kAnsLow; });
  }

 private:
  void refill(size_t lanes) {
    for (size_t lane = 0; lane < lanes; ++lane) {
      if (!ansWants(states_[lane])) continue;
      isBad_ |= reader_.left() < sizeof(uint16_t);
      states_[lane] = states_[lane] << 16 | (reader_.left() < sizeof(uint16_t) ? 0u : reader_.take<uint16_t>());
    }
  }

  ByteReader reader_;
  std::vector<uint32_t> states_ = std::vector<uint32_t>(kAnsLanes);
  bool isBad_ = false;
};

/// However many of them are taken at once: of sound streams and of damaged ones.
RC_GTEST_PROP(AnsLanes, AreWhatOneStateAfterTheOtherMakes, ()) {
  std::mt19937 random(*rc::gen::arbitrary<uint32_t>());
  const auto bits = *rc::gen::inRange<uint32_t>(1, 33);
  std::vector<uint8_t> symbols = randomSymbols(random, random() % 700, 2 + random() % (kAnsSymbols - 1));
  std::vector<uint32_t> numbers(random() % 700);
  for (uint32_t& number : numbers) number = static_cast<uint32_t>(uint64_t{random()} & ((uint64_t{1} << random() % (bits + 1)) - 1));
  symbols.insert(symbols.end(), {0, 1}), numbers.insert(numbers.end(), {0, 1});  // models of more than one symbol
  const AnsModel ofSymbols = modelOf(symbols), ofNumbers = modelOfNumbers(numbers);
  AnsWriter writer;
  PlainWriter plain;
  writer.begin();
  writer.putNumbers(AnsWriterModel(ofNumbers), numbers, tokensOf(numbers)), plain.putNumbers(ofNumbers, numbers);
  writer.putBytes(AnsWriterModel(ofSymbols), symbols), plain.putBytes(ofSymbols, symbols);
  ByteVector stream;
  writer.finish(stream);
  RC_ASSERT(stream == plain.finish());
  for (int damage = 0; damage < 4; ++damage) {
    for (int i = 0; i < damage; ++i) stream[random() % stream.size()] ^= static_cast<std::byte>(1u << random() % 8);
    if (damage == 2) std::fill_n(stream.begin() + static_cast<std::ptrdiff_t>(4 * (random() % kAnsLanes) + 1), 3, std::byte{0});  // a state that wants words at once
    if (damage == 3) stream.resize(stream.size() - std::min<size_t>(stream.size() - kAnsStateBytes, random() % 80));
    std::vector<uint8_t> foundSymbols(symbols.size());
    std::vector<uint32_t> foundNumbers(numbers.size());
    AnsReader reader(stream);
    reader.takeBytes(AnsReaderModel(ofSymbols), foundSymbols);
    reader.takeNumbers(AnsReaderModel(ofNumbers), foundNumbers);
    const bool areWhole = [&] {  // states and words
      ByteReader states(stream);
      for (uint32_t i = 0; i < kAnsLanes; ++i)
        if (ansWants(states.take<uint32_t>())) return false;
      return states.left() % sizeof(uint16_t) == 0;
    }();
    PlainReader plainReader(stream);
    RC_ASSERT(std::ranges::equal(foundSymbols, plainReader.take(ofSymbols, symbols.size(), false)));
    RC_ASSERT(foundNumbers == plainReader.take(ofNumbers, numbers.size(), true));
    RC_ASSERT(reader.isSound() == (areWhole && plainReader.isSound()));
    if (damage == 0) RC_ASSERT(reader.isSound() && foundSymbols == symbols && foundNumbers == numbers);
  }
}

/// However long they are, sound or damaged; with a model of several symbols, or of but one.
RC_GTEST_PROP(AnsLanes, TwoStreamsAtOnceAreThoseOneAfterTheOther, ()) {
  std::mt19937 random(*rc::gen::arbitrary<uint32_t>());
  const auto bits = *rc::gen::inRange<uint32_t>(1, 33);
  const bool isConstant = *rc::gen::inRange(0, 4) == 0;
  std::array<std::vector<uint8_t>, 2> symbols;
  std::array<std::vector<uint32_t>, 2> numbers;
  std::vector<uint8_t> allSymbols{0, static_cast<uint8_t>(isConstant ? 0 : 1)};
  std::vector<uint32_t> allNumbers{1000, isConstant ? 1000u : 1};
  for (size_t i = 0; i < 2; ++i) {
    symbols[i] = randomSymbols(random, random() % 300, isConstant ? 1 : 2 + random() % (kAnsSymbols - 1));
    numbers[i].resize(random() % 300);
    for (uint32_t& number : numbers[i]) number = isConstant ? 960 + random() % 64 : static_cast<uint32_t>(uint64_t{random()} & ((uint64_t{1} << random() % (bits + 1)) - 1));
    allSymbols.insert(allSymbols.end(), symbols[i].begin(), symbols[i].end());
    allNumbers.insert(allNumbers.end(), numbers[i].begin(), numbers[i].end());
  }
  const AnsModel ofSymbols = modelOf(allSymbols), ofNumbers = modelOfNumbers(allNumbers);
  std::array<ByteVector, 2> streams;
  for (size_t i = 0; i < 2; ++i) {
    AnsWriter writer;
    writer.begin();
    writer.putNumbers(AnsWriterModel(ofNumbers), numbers[i], tokensOf(numbers[i]));
    writer.putBytes(AnsWriterModel(ofSymbols), symbols[i]);
    writer.finish(streams[i]);
  }
  for (int damage = 0; damage < 3; ++damage) {
    if (ByteVector& stream = streams[random() % 2]; damage > 0 && !stream.empty()) stream[random() % stream.size()] ^= static_cast<std::byte>(1u << random() % 8);
    if (damage == 2) {
      ByteVector& stream = streams[random() % 2];
      stream.resize(stream.size() - std::min<size_t>(stream.size(), random() % 200));
    }
    std::array<AnsReader, 2> alone{AnsReader(streams[0]), AnsReader(streams[1])}, together = alone;
    std::array<std::vector<uint8_t>, 2> symbolsAlone, symbolsTogether;
    std::array<std::vector<uint32_t>, 2> numbersAlone, numbersTogether;
    for (size_t i = 0; i < 2; ++i) {
      symbolsAlone[i].resize(symbols[i].size());
      numbersAlone[i].resize(numbers[i].size());
      alone[i].takeBytes(AnsReaderModel(ofSymbols), symbolsAlone[i]);
      alone[i].takeNumbers(AnsReaderModel(ofNumbers), numbersAlone[i]);
    }
    symbolsTogether = symbolsAlone, numbersTogether = numbersAlone;
    for (size_t i = 0; i < 2; ++i) {
      std::ranges::fill(symbolsTogether[i], uint8_t{77});
      std::ranges::fill(numbersTogether[i], 77u);
    }
    AnsReader::takeBytes(AnsReaderModel(ofSymbols), together[0], symbolsTogether[0], together[1], symbolsTogether[1]);
    AnsReader::takeNumbers(AnsReaderModel(ofNumbers), together[0], numbersTogether[0], together[1], numbersTogether[1]);
    RC_ASSERT(symbolsTogether == symbolsAlone);
    RC_ASSERT(numbersTogether == numbersAlone);
    for (size_t i = 0; i < 2; ++i) RC_ASSERT(together[i].isSound() == alone[i].isSound());
    if (damage == 0) RC_ASSERT(symbolsTogether == symbols && numbersTogether == numbers && together[0].isSound() && together[1].isSound());
  }
}

}  // namespace
}  // namespace warpscope
