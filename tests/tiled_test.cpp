// The parts of the format `tiled`: models, streams, neighbours in tiles, and coders that leave a device.
// Mirrors render/codec/tiled/. Frames as a whole: codec_test.cpp and its kin; a device: gpu/codec_on_device_test.cpp.
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <numeric>
#include <random>

#include "render/base/error.h"
#include "render/codec/tiled/ans_lanes.h"
#include "render/codec/tiled/covered_bits.h"
#include "render/codec/tiled/tile_layer.h"
#include "render/codec/tiled/tiled_coder.h"
#include "render/codec/tokens.h"
#include "tests/codec_frames.h"
#include "tests/hostile_tiles.h"

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
    std::vector<std::byte> bytes;
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
    std::vector<std::byte> bytes;
    for (const int number : numbers) bytes.push_back(static_cast<std::byte>(number));
    ByteReader reader(bytes);
    AnsModel model;
    EXPECT_FALSE(model.take(reader)) << numbers.size();
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
  std::vector<std::byte> stream;
  for (int again = 0; again < 2; ++again) {  // a writer is used for many streams
    stream.clear();
    writer.begin();
    if (!second.empty()) writer.putBytes(AnsWriterModel(models[2]), second);
    if (!numbers.empty()) writer.putNumbers(AnsWriterModel(models[1]), numbers);
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
  std::vector<std::byte> stream;
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
  std::vector<std::byte> stream;
  writer.finish(stream);
  std::vector<uint8_t> back(symbols.size());
  for (size_t length = 0; length < stream.size(); ++length) {
    AnsReader reader(std::span<const std::byte>(stream.data(), length));
    reader.takeBytes(AnsReaderModel(model), back);
    EXPECT_FALSE(reader.isSound()) << length;
  }
  size_t unnoticed = 0;
  for (size_t i = 0; i < stream.size(); ++i) {
    std::vector<std::byte> changed = stream;
    changed[i] ^= std::byte{0x41};
    AnsReader reader(changed);
    reader.takeBytes(AnsReaderModel(model), back);
    unnoticed += reader.isSound() ? 1 : 0;
  }
  EXPECT_EQ(unnoticed, 0u);  // states end where writers began
}

TEST(CoveredBits, ThereAndBack) {
  std::mt19937 random(2);
  for (int round = 0; round < 2000; ++round) {
    uint8_t counts[8], back[8];
    for (uint8_t& count : counts) count = random() % 3 == 0 ? 0 : static_cast<uint8_t>(random() % 2 == 0 ? 0x80 : random());
    const uint32_t size = 1 + random() % 8, bits = coveredBits(counts, size);
    spreadBits(bits, back, size);
    for (uint32_t i = 0; i < size; ++i) {
      EXPECT_EQ(bits >> i & 1, counts[i] > 0 ? 1u : 0u);
      EXPECT_EQ(back[i], counts[i] > 0 ? 1 : 0);
    }
    EXPECT_EQ(bits >> size, 0u);
  }
}

/// What a pixel without neighbours is predicted from, as tile_layer.h says it: the slot of the last one of its row, else what the row above has one column on.
struct SeenRule {
  const TileRect& rect;
  const std::vector<uint32_t>& slots;  // of each pixel; 0 where there is nothing

  uint32_t at(int x, int y) const {
    if (y < 0) return 0;
    for (int left = std::min(x, static_cast<int>(rect.width) - 1); left >= 0; --left)
      if (const uint32_t slot = slots[static_cast<size_t>(y) * rect.width + static_cast<size_t>(left)]; slot != 0) return slot;
    return at(x + 1, y - 1);
  }
};

TEST(TileLayer, NeighboursAreThoseOfTheRule) {
  std::mt19937 random(12);
  for (int round = 0; round < 200; ++round) {
    const auto below = [&](uint32_t limit) { return static_cast<uint32_t>(random() % limit); };
    const TileRect rect{kCodedTileWidth * below(3), kCodedTileHeight * below(3), 1 + below(kCodedTileWidth), 1 + below(kCodedTileHeight)};
    const uint32_t rarity = 1 + below(12);
    std::vector<uint8_t> counts(rect.pixels());
    for (uint8_t& count : counts) count = random() % rarity == 0 ? static_cast<uint8_t>(1 + random() % 3) : 0;
    TileLayer layer;
    layer.begin(rect, counts);
    for (uint32_t l = 0;; ++l) {
      std::vector<uint32_t> slots(rect.pixels(), 0);
      size_t k = 0;
      for (uint32_t pixel = 0; pixel < rect.pixels(); ++pixel) {
        if (counts[pixel] <= l) continue;
        const auto x = static_cast<int>(pixel % rect.width), y = static_cast<int>(pixel / rect.width);
        ASSERT_LT(k, layer.size());
        ASSERT_EQ(layer.pixels()[k], pixel);
        ASSERT_EQ(layer.columns()[k], rect.x0 + static_cast<uint32_t>(x));
        ASSERT_EQ(layer.rows()[k], rect.y0 + static_cast<uint32_t>(y));
        const auto slotAt = [&](int column, int row) { return column < 0 || row < 0 ? 0u : slots[static_cast<size_t>(row) * rect.width + static_cast<size_t>(column)]; };
        uint32_t west = slotAt(x - 1, y), north = slotAt(x, y - 1), northWest = slotAt(x - 1, y - 1);
        if (west == 0) west = north;
        if (north == 0) north = west;
        if (west == 0) west = north = SeenRule{rect, slots}.at(x, y);
        if (northWest == 0) northWest = north;
        const Neighbors own = layer.neighbors()[k];
        ASSERT_EQ(own.west, west) << round << ", " << l << ": " << x << ", " << y;
        ASSERT_EQ(own.north, north);
        ASSERT_EQ(own.northWest, northWest);
        slots[pixel] = static_cast<uint32_t>(++k);
      }
      ASSERT_EQ(k, layer.size());
      if (!layer.goBehind()) break;
    }
  }
}

TEST(TiledPayload, TilesOfLayersThatHaveNoModelsAreRefused) {
  for (const HostilePayload& hostile : tilesWithoutModels()) {
    SampleFrame head = hostile.head;
    EXPECT_EQ(FrameCodec().decode(hostile.payload, hostile.count, head), hostile.sentence) << hostile.what;
  }
}

/// A device that fails at its call number `calls`.
class FailingCoder final : public TiledCoder {
 public:
  explicit FailingCoder(int calls) : left_(calls) {}

  void appendSamples(std::vector<std::byte>& out, const SampleFrame& frame, Placement placement) override {
    out.push_back(std::byte{99});  // half of it
    work();
    out.pop_back();
    host_->appendSamples(out, frame, placement);
  }
  DecodeError takeSamples(ByteReader& reader, Placement placement, size_t count, SampleFrame& frame) override {
    if (left_ <= 1) reader.take<uint32_t>();
    work();
    return host_->takeSamples(reader, placement, count, frame);
  }
  void appendSegments(std::vector<std::byte>& out, const SampleFrame& frame, Placement placement) override {
    work();
    host_->appendSegments(out, frame, placement);
  }
  DecodeError takeSegments(ByteReader& reader, Placement placement, bool hasNormals, size_t most, SampleFrame& frame) override {
    work();
    return host_->takeSegments(reader, placement, hasNormals, most, frame);
  }
  void beginToAppendSamples(const SampleFrame&, Placement) override { work(); }
  void beginToTakeSamples(ByteReader, Placement, size_t, const SampleFrame&) override { work(); }
  void forget() override {}

 private:
  void work() {
    if (--left_ <= 0) throw DeviceError("unplugged");
  }

  int left_;
  const TiledCoderPtr host_ = makeHostTiledCoder();
};

TEST(FallbackTiledCoder, FramesGoOnOnTheHostAndTheReasonIsToldOnce) {
  MarchSettings settings;
  settings.sample.segments = 2;
  const SampleFrame frame = marched(shells(), settings, 80, 50);
  const std::vector<std::byte> payload = FrameCodec().encode(frame, kTiled);
  for (int calls = 0; calls < 8; ++calls) {
    std::vector<std::string> told;
    FrameCodec codec(makeFallbackTiledCoder(
        [calls]() -> TiledCoderPtr {
          if (calls == 0) throw DeviceError("none");
          return std::make_shared<FailingCoder>(calls);
        },
        [&](const std::string& reason) { told.push_back(reason); }));
    for (int round = 0; round < 2; ++round) {
      EXPECT_TRUE(codec.encode(frame, kTiled) == payload) << calls;
      SampleFrame back = headOf(frame);
      ASSERT_EQ(codec.decode(payload, frame.size(), back), std::nullopt) << calls;
      EXPECT_EQ(back.samples, frame.samples);
      EXPECT_EQ(back.segments.depths, frame.segments.depths);
    }
    EXPECT_EQ(told, std::vector<std::string>{calls == 0 ? "none" : "unplugged"});
  }
}

/// Knows whether something was begun and not ended.
class WatchedCoder final : public TiledCoder {
 public:
  void beginToAppendSamples(const SampleFrame&, Placement) override { isBegun = true; }
  void beginToTakeSamples(ByteReader, Placement, size_t, const SampleFrame&) override { isBegun = true; }
  void appendSamples(std::vector<std::byte>& out, const SampleFrame& frame, Placement placement) override {
    EXPECT_TRUE(isBegun);
    host_->appendSamples(out, frame, placement);
  }
  DecodeError takeSamples(ByteReader& reader, Placement placement, size_t count, SampleFrame& frame) override {
    EXPECT_TRUE(isBegun);
    return host_->takeSamples(reader, placement, count, frame);
  }
  void appendSegments(std::vector<std::byte>& out, const SampleFrame& frame, Placement placement) override {
    EXPECT_TRUE(isBegun);
    if (isFailing) throw DeviceError("unplugged");
    host_->appendSegments(out, frame, placement);
  }
  DecodeError takeSegments(ByteReader& reader, Placement placement, bool hasNormals, size_t most, SampleFrame& frame) override {
    EXPECT_TRUE(isBegun);
    return host_->takeSegments(reader, placement, hasNormals, most, frame);
  }
  void endBegun() override { isBegun = false; }
  void forget() override { ++forgotten; }

  bool isBegun = false, isFailing = false;
  int forgotten = 0;

 private:
  const TiledCoderPtr host_ = makeHostTiledCoder();
};

TEST(TiledCoder, SamplesAreBegunBeforeAllElseAndEndHoweverTheFrameDoes) {
  const auto coder = std::make_shared<WatchedCoder>();
  FrameCodec codec(coder);
  MarchSettings settings;
  settings.sample.segments = 2;
  const SampleFrame large = marched(shells(), settings, 300, 200), small = marched(shells(), settings, 12, 9);
  const std::vector<std::byte> payload = codec.encode(large, kTiled);
  EXPECT_FALSE(coder->isBegun);
  for (int i = 0; i < 100 && coder->forgotten == 0; ++i) {  // until what the large frame needed is given back
    codec.encode(small, kTiled);
    EXPECT_FALSE(coder->isBegun);
  }
  EXPECT_GT(coder->forgotten, 0);
  for (const size_t damaged : {payload.size(), payload.size() / 2}) {
    std::vector<std::byte> bytes(payload.begin(), payload.begin() + static_cast<std::ptrdiff_t>(damaged));
    SampleFrame back = headOf(large);
    EXPECT_EQ(codec.decode(sealed(std::move(bytes)), large.size(), back).has_value(), damaged < payload.size());
    EXPECT_FALSE(coder->isBegun);
  }
  coder->isFailing = true;
  EXPECT_THROW(codec.encode(large, kTiled), DeviceError);
  EXPECT_FALSE(coder->isBegun);
}

/// What a device and processors of every kind have to make as well, and versions to come to read.
TEST(TiledPayload, IsTheSameEverywhere) {
  std::vector<uint32_t> pixels;
  for (uint32_t i = 0; i < 200 * 90; i += 1 + i % 7 + (i % 900 < 300 ? 40 : 0)) pixels.push_back(i);
  const std::vector<std::byte> payload = FrameCodec().encode(framedPixels(200, 90, pixels, 4), kTiled);
  EXPECT_EQ(payload.size(), 21652u);
  EXPECT_EQ(hashBytes(payload, 0), 6508679501248068932u);
}

}  // namespace
}  // namespace warpscope
