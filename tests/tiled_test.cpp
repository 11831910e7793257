// The parts of the format `tiled`: colours, neighbours in tiles, and coders that leave a device. Streams: ans_test.cpp.
// Mirrors render/codec/tiled/. Frames as a whole: codec_test.cpp and its kin; a device: gpu/codec_on_device_test.cpp.
#include <gtest/gtest.h>

#include <random>

#include "render/base/error.h"
#include "render/codec/bytes.h"
#include "render/codec/color_differences.h"
#include "render/codec/payload_hash.h"
#include "render/codec/tiled/covered_bits.h"
#include "render/codec/tiled/tile_layer.h"
#include "render/codec/tiled/tiled_coder.h"
#include "render/core/placed_hash.h"
#include "tests/codec_frames.h"
#include "tests/hostile_tiles.h"

namespace warpscope {
namespace {

TEST(ColorChannels, ArePredictedAndAddedEachForItself) {
  std::mt19937 random(7);
  for (int round = 0; round < 20000; ++round) {
    const auto color = [&] { return static_cast<Rgba8>(round % 2 == 0 ? random() : random() & 0x03030303u); };
    const Rgba8 west = color(), north = color(), northWest = color();
    const ColorChannels likely = ColorChannels::predicted(ColorChannels(west), ColorChannels(north), ColorChannels(northWest));
    const Rgba8 sum = (ColorChannels(west) + ColorChannels(north)).color(), difference = (ColorChannels(west) - ColorChannels(north)).color();
    for (const int shift : {0, 8, 16, 24}) {
      ASSERT_EQ(channel(likely.color(), shift), predicted(channel(west, shift), channel(north, shift), channel(northWest, shift))) << round;
      ASSERT_EQ(channel(sum, shift), (channel(west, shift) + channel(north, shift)) & 255);
      ASSERT_EQ(channel(difference, shift), (channel(west, shift) - channel(north, shift)) & 255);
    }
  }
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

/// Of each value. Says what is wrong with the runs.
std::vector<Neighbors> neighborsOf(std::span<const NeighborRun> runs) {
  std::vector<Neighbors> neighbors;
  for (const NeighborRun& run : runs) {
    EXPECT_EQ(run.begin, neighbors.size());
    EXPECT_GT(run.size, 0u);
    EXPECT_TRUE(run.size == 1 || run.first.west == run.begin) << "what a decoder made last is not what is to the west";
    for (uint32_t i = 0; i < run.size; ++i) neighbors.push_back(run.at(i));
  }
  return neighbors;
}

/// `seen`: of a pixel that has no neighbours.
template <class SlotAt, class Seen>
Neighbors expectedNeighbors(int x, int y, const SlotAt& slotAt, const Seen& seen) {
  uint32_t west = slotAt(x - 1, y), north = slotAt(x, y - 1), northWest = slotAt(x - 1, y - 1);
  if (west == 0) west = north;
  if (north == 0) north = west;
  if (west == 0) west = north = seen();
  if (northWest == 0) northWest = north;
  return {west, north, northWest};
}

TEST(TileLayer, NeighboursAreThoseOfTheRule) {
  std::mt19937 random(12);
  TileLayer layer;  // keeps its buffers
  int fullRows = 0;
  for (int round = 0; round < 300; ++round) {
    const auto below = [&](uint32_t limit) { return static_cast<uint32_t>(random() % limit); };
    const bool isWhole = round % 3 == 0;
    const TileRect rect{kCodedTileWidth * below(3), kCodedTileHeight * below(3), isWhole ? kCodedTileWidth : 1 + below(kCodedTileWidth), isWhole ? kCodedTileHeight : 1 + below(kCodedTileHeight)};
    const uint32_t inThousand = round % 2 == 0 ? 1000 - below(1 + below(60)) : below(1000);  // nearly full and full, as pictures are; anything
    std::vector<uint8_t> counts(rect.pixels());
    for (uint8_t& count : counts) count = below(1000) < inThousand ? static_cast<uint8_t>(1 + random() % 3) : 0;
    layer.begin(rect, counts);
    std::vector<uint32_t> pixelsInFront;
    for (uint32_t l = 0;; ++l) {
      std::vector<uint32_t> slots(rect.pixels(), 0), pixels;
      const std::vector<Neighbors> neighbors = neighborsOf(layer.runs());
      ASSERT_EQ(neighbors.size(), layer.size());
      size_t k = 0;
      for (uint32_t pixel = 0; pixel < rect.pixels(); ++pixel) {
        if (counts[pixel] <= l) continue;
        const auto x = static_cast<int>(pixel % rect.width), y = static_cast<int>(pixel / rect.width);
        ASSERT_LT(k, layer.size());
        ASSERT_EQ(layer.pixelOf(k), pixel);
        ASSERT_EQ(layer.columns()[k], rect.x0 + static_cast<uint32_t>(x));
        ASSERT_EQ(layer.rows()[k], rect.y0 + static_cast<uint32_t>(y));
        if (l > 0) {
          ASSERT_EQ(pixelsInFront[layer.kept()[k]], pixel);
        }
        const auto slotAt = [&](int column, int row) { return column < 0 || row < 0 ? 0u : slots[static_cast<size_t>(row) * rect.width + static_cast<size_t>(column)]; };
        ASSERT_EQ(neighbors[k], expectedNeighbors(x, y, slotAt, [&] { return SeenRule{rect, slots}.at(x, y); })) << round << ", " << l << ": " << x << ", " << y;
        pixels.push_back(pixel);
        slots[pixel] = static_cast<uint32_t>(++k);
      }
      ASSERT_EQ(k, layer.size());
      fullRows += rect.width == kCodedTileWidth && layer.size() == rect.pixels() ? 1 : 0;
      pixelsInFront = std::move(pixels);
      if (!layer.goBehind()) break;
    }
  }
  EXPECT_GT(fullRows, 0);
}

TEST(BandLayout, NeighboursAreThoseOfTheRule) {
  std::mt19937 random(13);
  BandLayout layout;  // keeps its buffers
  for (int round = 0; round < 300; ++round) {
    const auto below = [&](uint32_t limit) { return static_cast<uint32_t>(random() % limit); };
    const uint32_t width = 1 + below(100), rows = 1 + below(20), firstRow = below(50), rowBytes = (width + 7) / 8;
    const uint32_t inThousand = round % 2 == 0 ? 1000 - below(1 + below(60)) : below(1000);
    std::vector<uint8_t> mask(size_t{rowBytes} * rows);
    std::vector<uint32_t> slots(size_t{width} * rows);
    for (uint32_t y = 0; y < rows; ++y)
      for (uint32_t x = 0; x < width; ++x)
        if (below(1000) < inThousand) mask[size_t{y} * rowBytes + x / 8] |= static_cast<uint8_t>(1u << x % 8);
    layout.build(width, firstRow, rows, mask);
    const std::vector<Neighbors> neighbors = neighborsOf(layout.runs);
    ASSERT_EQ(neighbors.size(), layout.size());
    uint32_t k = 0;
    for (uint32_t y = 0; y < rows; ++y)
      for (uint32_t x = 0; x < width; ++x) {
        if ((mask[size_t{y} * rowBytes + x / 8] >> x % 8 & 1) == 0) continue;
        ASSERT_LT(k, layout.size());
        ASSERT_EQ(layout.columns[k], x);
        ASSERT_EQ(layout.rows[k], firstRow + y);
        const auto slotAt = [&](int column, int row) { return column < 0 || row < 0 ? 0u : slots[static_cast<size_t>(row) * width + static_cast<size_t>(column)]; };
        ASSERT_EQ(neighbors[k], expectedNeighbors(static_cast<int>(x), static_cast<int>(y), slotAt, [&] { return k; })) << round << ": " << x << ", " << y;
        slots[size_t{y} * width + x] = ++k;
      }
    ASSERT_EQ(k, layout.size());
  }
}

/// A format that other machines, devices and releases read: what a frame is coded as does not change by itself. Frames are made up, so that nobody's march has a part in it.
TEST(TiledPayload, BytesAreThoseOfTheFormat) {
  std::vector<uint32_t> dense, rays;
  for (uint32_t pixel = 0; pixel < 150 * 70; ++pixel) {
    if (pixel % 97 != 5) dense.push_back(pixel);
    if (pixel % 5 != 0) rays.insert(rays.end(), 1 + pixel % 3, pixel);
  }
  SampleFrame layered = withLayers(framedPixels(150, 70, rays), rays);
  const std::pair<SampleFrame, uint64_t> frames[] = {
      {garbageFrame(150, 70, 9000, 3), 0x7bbe608ad439ed43u}, {framedPixels(150, 70, dense), 0x66196fc7493c0f94u}, {std::move(layered), 0xcbf4c679059c13d6u}};
  for (const auto& [frame, hash] : frames) EXPECT_EQ(payloadHash(FrameCodec().encode(frame, kTiled)), hash) << frame.size();
}

TEST(TiledPayload, TilesOfLayersThatHaveNoModelsAreRefused) {
  for (const HostilePayload& hostile : tilesWithoutModels()) {
    SampleFrame head = hostile.head;
    EXPECT_EQ(FrameCodec().decode(hostile.payload, hostile.count, head), hostile.sentence) << hostile.what;
  }
}

TEST(Predicted, IsThePlaneHeldBetweenNeighboursWhateverTheyAre) {
  std::mt19937 random(11);
  const auto any = [&] { return static_cast<int32_t>(random() % 4 == 0 ? random() : random() % 7 == 0 ? 0x7fffffffu + random() % 2 : random() % 16); };
  for (int round = 0; round < 100000; ++round) {
    const int32_t west = any(), north = any(), northWest = any();
    const int64_t plane = int64_t{west} + north - northWest;
    ASSERT_EQ(predicted(west, north, northWest), std::clamp(plane, int64_t{std::min(west, north)}, int64_t{std::max(west, north)})) << west << " " << north << " " << northWest;
  }
}

/// A device that fails at its call number `calls`.
class FailingCoder final : public TiledCoder {
 public:
  explicit FailingCoder(int calls) : left_(calls) {}

  void appendSamples(ByteVector& out, const SampleFrame& frame, Placement placement) override {
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
  void appendSegments(ByteVector& out, const SampleFrame& frame, Placement placement) override {
    work();
    host_->appendSegments(out, frame, placement);
  }
  DecodeError takeSegments(ByteReader& reader, Placement placement, bool hasNormals, size_t most, SampleFrame& frame) override {
    work();
    return host_->takeSegments(reader, placement, hasNormals, most, frame);
  }
  void beginToAppendSegments(const SampleFrame&, Placement) override { work(); }
  void beginToAppendSamples(const SampleFrame&, Placement) override { work(); }
  void beginToTakeSegments(ByteReader, Placement, bool, size_t, const SampleFrame&) override { work(); }
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
  const ByteVector payload = FrameCodec().encode(frame, kTiled);
  for (int calls = 0; calls < 9; ++calls) {
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

/// A device that adds up words of segments, `isWrong` wrongly, and fails at samples if it is to.
class SummingCoder final : public TiledCoder {
 public:
  SummingCoder(bool isWrong, bool fails) : isWrong_(isWrong), fails_(fails) {}

  void appendSegments(ByteVector& out, const SampleFrame& frame, Placement placement) override {
    const size_t at = out.size();
    host_->appendSegments(out, frame, placement);
    SummedWords words = SummedWords::within(at, out.size() - at);
    for (size_t i = 0; i < words.count(); ++i) words.sum += placedHash(loadLittle<uint64_t>(out.data() + words.firstByte() + kHashedWordBytes * i), words.begin + i);
    words.sum += isWrong_ ? 1 : 0;
    summed_.push_back(words);
  }
  void appendSamples(ByteVector& out, const SampleFrame& frame, Placement placement) override {
    if (fails_) throw DeviceError("unplugged");
    host_->appendSamples(out, frame, placement);
  }
  DecodeError takeSamples(ByteReader&, Placement, size_t, SampleFrame&) override { return "not asked for"; }
  DecodeError takeSegments(ByteReader&, Placement, bool, size_t, SampleFrame&) override { return "not asked for"; }
  std::vector<SummedWords> takeSummed() override { return std::exchange(summed_, {}); }
  void forget() override {}

 private:
  const bool isWrong_, fails_;
  std::vector<SummedWords> summed_;
  const TiledCoderPtr host_ = makeHostTiledCoder();
};

TEST(FallbackTiledCoder, WhatWasAddedUpCountsUnlessTheDeviceFails) {
  MarchSettings settings;
  settings.sample.segments = 2;
  const SampleFrame frame = marched(shells(), settings, 80, 50);
  const ByteVector payload = FrameCodec().encode(frame, kTiled);
  const auto encoded = [&](bool isWrong, bool fails) {
    FrameCodec codec(makeFallbackTiledCoder([=] { return std::make_shared<SummingCoder>(isWrong, fails); }, {}));
    return codec.encode(frame, kTiled);
  };
  EXPECT_TRUE(encoded(false, false) == payload);
  EXPECT_FALSE(encoded(true, false) == payload) << "nobody listens to the device";
  EXPECT_TRUE(encoded(true, true) == payload);
}

/// Knows whether something was begun and not ended.
class WatchedCoder final : public TiledCoder {
 public:
  void beginToAppendSegments(const SampleFrame&, Placement) override { areSegmentsBegun = true; }
  void beginToAppendSamples(const SampleFrame&, Placement) override {
    EXPECT_TRUE(areSegmentsBegun);  // which take longer
    isBegun = true;
  }
  void beginToTakeSegments(ByteReader, Placement, bool, size_t, const SampleFrame&) override { areSegmentsBegun = true; }
  void beginToTakeSamples(ByteReader, Placement, size_t, const SampleFrame&) override {
    EXPECT_TRUE(areSegmentsBegun);
    isBegun = true;
  }
  void appendSamples(ByteVector& out, const SampleFrame& frame, Placement placement) override {
    EXPECT_TRUE(isBegun);
    host_->appendSamples(out, frame, placement);
  }
  DecodeError takeSamples(ByteReader& reader, Placement placement, size_t count, SampleFrame& frame) override {
    EXPECT_TRUE(isBegun);
    return host_->takeSamples(reader, placement, count, frame);
  }
  void appendSegments(ByteVector& out, const SampleFrame& frame, Placement placement) override {
    EXPECT_TRUE(isBegun && areSegmentsBegun);
    if (isFailing) throw DeviceError("unplugged");
    host_->appendSegments(out, frame, placement);
  }
  DecodeError takeSegments(ByteReader& reader, Placement placement, bool hasNormals, size_t most, SampleFrame& frame) override {
    EXPECT_TRUE(isBegun && areSegmentsBegun);
    return host_->takeSegments(reader, placement, hasNormals, most, frame);
  }
  void endBegun() override { isBegun = areSegmentsBegun = false; }
  void forget() override { ++forgotten; }

  bool isBegun = false, areSegmentsBegun = false, isFailing = false;
  int forgotten = 0;

 private:
  const TiledCoderPtr host_ = makeHostTiledCoder();
};

TEST(TiledCoder, SegmentsAndSamplesAreBegunBeforeAllElseAndEndHoweverTheFrameDoes) {
  const auto coder = std::make_shared<WatchedCoder>();
  FrameCodec codec(coder);
  MarchSettings settings;
  settings.sample.segments = 2;
  const SampleFrame large = marched(shells(), settings, 300, 200), small = marched(shells(), settings, 12, 9);
  const ByteVector payload = codec.encode(large, kTiled);
  EXPECT_FALSE(coder->isBegun);
  for (int i = 0; i < 100 && coder->forgotten == 0; ++i) {  // until what the large frame needed is given back
    codec.encode(small, kTiled);
    EXPECT_FALSE(coder->isBegun);
  }
  EXPECT_GT(coder->forgotten, 0);
  for (const size_t damaged : {payload.size(), payload.size() / 2}) {
    ByteVector bytes(payload.begin(), payload.begin() + static_cast<std::ptrdiff_t>(damaged));
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
  const ByteVector payload = FrameCodec().encode(framedPixels(200, 90, pixels, 4), kTiled);
  EXPECT_EQ(payload.size(), 21652u);
  EXPECT_EQ(hashBytes(payload, 0), 6508679501248068932u);
}

}  // namespace
}  // namespace warpscope
