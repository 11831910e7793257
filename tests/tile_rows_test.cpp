// What the tiled format does with many values at once on the host: rows without gaps, counts of symbols, steps of rays. Each against the plain rule.
// Mirrors render/codec/neighbor_rows.h, render/codec/tiled/symbol_counts.h, render/codec/tiled/byte_block.h and render/codec/step_counts.h.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <vector>

#include "render/codec/color_differences.h"
#include "render/codec/place_differences.h"
#include "render/codec/step_counts.h"
#include "render/codec/tiled/byte_block.h"
#include "render/codec/tiled/symbol_counts.h"
#include "render/codec/tiled/tile_layer.h"
#include "render/codec/tiled/tile_making.h"

namespace warpscope {
namespace {

/// What a decoder makes of a layer's values.
struct Made {
  std::vector<int32_t> fine, places;
  std::vector<Rgba8> colors;

  bool operator==(const Made&) const = default;
};

/// Differences and origins of a layer's values.
struct Given {
  std::vector<int32_t> origins;
  std::vector<uint32_t> places;
  std::vector<Rgba8> colors;
  int bits;

  FineScale scale() const { return {origins.data(), bits}; }
};

/// Makes what a layer has in rows and in runs alone. Returns how many values rows have.
size_t expectRowsAsRuns(const TileLayer& layer, uint32_t width, const Given& given) {
  const auto made = [&](const auto& make) {
    Made all{std::vector<int32_t>(layer.size() + 1), std::vector<int32_t>(layer.size()), std::vector<Rgba8>(layer.size() + 1)};
    make(makingTilePlaces(given.scale(), given.places.data(), all.fine.data(), all.places.data()), makingTileColors(given.colors.data(), all.colors.data()));
    return all;
  };
  const Made expected = made([&](const auto& places, const auto& colors) { makeFromNeighbors(layer.runs(), places.inRuns, colors.inRuns); });
  const Made found = made([&](const auto& places, const auto& colors) { makeFromNeighbors(layer, places, colors); });
  EXPECT_EQ(found, expected);
  size_t next = 0, inRows = 0;  // parts are all values, in order
  layer.forEachPart(
      [&](std::span<const NeighborRun> runs) {
        for (const NeighborRun& run : runs) {
          EXPECT_EQ(run.begin, next);
          next += run.size;
        }
      },
      [&](const NeighborRows& rows) {
        EXPECT_EQ(rows.begin, next);
        EXPECT_EQ(rows.width, width);
        EXPECT_EQ(rows.count % kRowsAtOnce, 0u);
        EXPECT_GE(rows.begin, rows.width);
        next += size_t{rows.width} * rows.count;
        inRows += size_t{rows.width} * rows.count;
      });
  EXPECT_EQ(next, layer.size());
  return inRows;
}

TEST(NeighborRows, MakeWhatRunsMake) {
  std::mt19937 random(21);
  const auto below = [&](uint32_t limit) { return static_cast<uint32_t>(random() % limit); };
  TileLayer layer;
  for (const uint32_t width : {1, 3, 4, 5, 8, 60, 62, 64})
    for (const uint32_t height : {1, 4, 5, 6, 8, 9, 32}) {
      size_t inRows = 0;
      for (int round = 0; round < 12; ++round) {
        const TileRect rect{0, 0, width, height};
        std::vector<uint8_t> counts(rect.pixels(), 2);
        for (uint32_t gaps = round % 4 < 2 ? 0 : below(2 + rect.pixels() / 100); gaps-- > 0;) counts[below(rect.pixels())] = static_cast<uint8_t>(below(3));
        layer.begin(rect, counts);
        do {
          const bool isWild = round % 3 == 0;  // places from all over, which wrap around
          Given given{{}, {}, {}, static_cast<int>(below(5))};
          for (size_t k = 0; k < layer.size(); ++k) {
            given.origins.push_back(static_cast<int32_t>(isWild ? random() : below(5000)));
            given.places.push_back(isWild ? static_cast<uint32_t>(random()) : below(9));
            given.colors.push_back(static_cast<Rgba8>(random()));
          }
          SCOPED_TRACE(testing::Message() << width << " x " << height << ", round " << round);
          inRows += expectRowsAsRuns(layer, width, given);
          if (testing::Test::HasFailure()) return;
        } while (layer.goBehind());
      }
      EXPECT_EQ(inRows > 0, width % kRowsAtOnce == 0 && height > kRowsAtOnce) << width << " x " << height;
    }
}

TEST(SymbolCounts, AreThoseOfCountingOneByOne) {
  std::mt19937 random(4);
  for (int round = 0; round < 300; ++round) {
    SymbolCounts counts;
    std::array<uint32_t, kAnsSymbols> expected{}, found{};
    for (int part = 0; part < 3; ++part) {  // planes of several tiles
      std::vector<uint8_t> symbols(random() % 400);
      const uint32_t spread = 1 + random() % (round % 2 == 0 ? 6 : 256);
      for (uint8_t& symbol : symbols) {
        symbol = static_cast<uint8_t>(random() % spread - spread / 2);
        ++expected[symbol];
      }
      counts.add(symbols);
    }
    counts.addTo(found);
    ASSERT_EQ(found, expected) << round;
  }
}

#ifdef WARPSCOPE_HAS_BYTE_BLOCKS
TEST(ByteBlock, EachBitIsAByte) {
  std::mt19937 random(6);
  for (int round = 0; round < 300; ++round) {
    std::array<uint8_t, ByteBlock::kSize + 1> bytes;
    for (uint8_t& byte : bytes) byte = static_cast<uint8_t>(0xfe + random() % 4);
    for (const uint8_t byte : {0xfe, 0xff, 0, 1}) {
      const uint64_t bits = ByteBlock(bytes.data() + 1).equalTo(byte);
      for (size_t i = 0; i < ByteBlock::kSize; ++i) ASSERT_EQ(bits >> i & 1, bytes[i + 1] == byte ? 1u : 0u) << round << ", " << i;
    }
  }
}
#endif

TEST(CountSteps, AreThoseOfTheMarcher) {
  std::mt19937 random(8);
  const auto expectSame = [](const std::vector<float>& lengths, float step) {
    std::vector<int32_t> counts(lengths.size());
    countSteps(lengths, step, counts);
    for (size_t k = 0; k < lengths.size(); ++k) ASSERT_EQ(counts[k], makeLattice({0.0f, lengths[k]}, step).count) << lengths[k] << " by " << step;
  };
  const auto someStep = [&] { return std::ldexp(static_cast<float>(1 + random() % 0xffffff), static_cast<int>(random() % 60) - 40); };
  std::vector<float> steps{1.0f, 0.5f, 0.25f, 0.1f, 0.3f, 1.0f / 3.0f, 3.0f, 5.0f, 7.0f, 10.0f, 0.75f, 7.7f, 1e-3f, 1e-9f, 1e-30f, 1e-42f, 0.0f, -1.0f, INFINITY, NAN};
  for (int i = 0; i < 500; ++i) steps.push_back(someStep());
  for (const float step : steps) {
    std::vector<float> lengths;
    for (int exponent = 0; exponent < 30; ++exponent)
      for (int i = 0; i < 6; ++i) {
        const double whole = static_cast<double>((uint32_t{1} << exponent) + random() % (uint32_t{1} << exponent)) * static_cast<double>(step);
        const auto length = static_cast<float>(whole);
        lengths.insert(lengths.end(), {length, std::nextafter(length, 0.0f), std::nextafter(length, INFINITY)});
      }
    expectSame(lengths, step);
    for (const float length : lengths) expectSame({length}, step);
    for (const float odd : {0.0f, -0.0f, 1e-45f, INFINITY, NAN, -NAN}) {  // beside others, which may be very long
      std::vector<float> mixed{0.0f, lengths[random() % lengths.size()], odd, step * 0x1p31f};
      mixed.resize(2 + random() % 3);
      std::ranges::shuffle(mixed, random);
      expectSame(mixed, step);
    }
  }
}

}  // namespace
}  // namespace warpscope
