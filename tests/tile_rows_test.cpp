// What the tiled format does with many values at once on the host: rows without gaps, counts of symbols, steps of rays. Each against the plain rule.
// Mirrors render/codec/neighbor_rows.h, render/codec/tiled/symbol_counts.h, render/codec/tiled/byte_block.h and render/codec/pixel_path.h.
#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "render/codec/color_differences.h"
#include "render/codec/pixel_path.h"
#include "render/codec/place_differences.h"
#include "render/codec/tiled/byte_block.h"
#include "render/codec/tiled/symbol_counts.h"
#include "render/codec/tiled/tile_layer.h"
#include "render/codec/tiled/tile_making.h"
#include "render/march/frame_places.h"
#include "tests/codec_frames.h"

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

TEST(NeighborRows, MakeWhatRunsMake) {
  std::mt19937 random(21);
  TileLayer layer;
  size_t inRows = 0;
  for (int round = 0; round < 400; ++round) {
    const auto below = [&](uint32_t limit) { return static_cast<uint32_t>(random() % limit); };
    const TileRect rect{0, 0, round % 2 == 0 ? kCodedTileWidth : 1 + below(kCodedTileWidth), 1 + below(kCodedTileHeight)};
    std::vector<uint8_t> counts(rect.pixels(), 1);
    for (uint32_t gaps = round % 4 < 2 ? 0 : below(1 + rect.pixels() / 100); gaps-- > 0;) counts[below(rect.pixels())] = 0;
    layer.begin(rect, counts);
    const bool isWild = round % 3 == 0;  // places from all over, which wrap around
    Given given{{}, {}, {}, static_cast<int>(below(5))};
    for (size_t k = 0; k < layer.size(); ++k) {
      given.origins.push_back(static_cast<int32_t>(isWild ? random() : below(5000)));
      given.places.push_back(isWild ? static_cast<uint32_t>(random()) : below(9));
      given.colors.push_back(static_cast<Rgba8>(random()));
    }
    const auto made = [&](const auto& make) {
      Made all{std::vector<int32_t>(layer.size() + 1), std::vector<int32_t>(layer.size()), std::vector<Rgba8>(layer.size() + 1)};
      const auto places = makingPlaces(given.scale(), [&](size_t k) { return given.places[k]; }, all.fine.data(), all.places.data());
      make(all, places, makingColors(given.colors.data(), all.colors.data()));
      return all;
    };
    const Made expected = made([&](Made&, const auto& places, const auto& colors) { makeFromNeighbors(layer.runs(), places, colors); });
    const Made found = made([&](Made& all, const auto& places, const auto& colors) {
      makeFromNeighbors(layer, TileMaking{places, RowMaking(PlacesInRows{given.scale(), given.places.data(), all.fine.data(), all.places.data()})},
                        TileMaking{colors, RowMaking(ColorsInRows{given.colors.data(), all.colors.data()})});
    });
    ASSERT_EQ(found, expected) << round << ": " << rect.width << " x " << rect.height;
    size_t next = 0;  // parts are all values, in order
    layer.forEachPart(
        [&](std::span<const NeighborRun> runs) {
          for (const NeighborRun& run : runs) {
            ASSERT_EQ(run.begin, next);
            next += run.size;
          }
        },
        [&](const NeighborRows& rows) {
          ASSERT_EQ(rows.begin, next);
          ASSERT_EQ(rows.width, rect.width);
          ASSERT_EQ(rows.count % kRowsAtOnce, 0u);
          ASSERT_GE(rows.begin, rect.width);
          next += size_t{rows.width} * rows.count;
          inRows += size_t{rows.width} * rows.count;
        });
    ASSERT_EQ(next, layer.size());
  }
  EXPECT_GT(inRows, 50000u);
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

/// Depth codes of places, with all rays of a picture at once and with each alone: they tell how many steps a ray has.
void expectPathsOf(const SampleFrame& frame, Placement placement) {
  TransferVector<uint32_t> columns, rows;
  for (uint32_t row = 0; row < frame.camera.height; ++row)
    for (uint32_t column = 0; column < frame.camera.width; ++column) {
      columns.push_back(column);
      rows.push_back(row);
    }
  PixelPaths paths;
  paths.aim(frame, placement, columns, rows);
  const PathGrid grid = pathGridOf(frame, placement);
  std::vector<int32_t> places(columns.size());
  std::vector<uint32_t> codes(columns.size());
  for (const int fromEnd : {0, 1, 2}) {
    std::vector<PixelPath> each;
    for (size_t k = 0; k < columns.size(); ++k) {
      each.push_back(grid.path(columns[k], rows[k]));
      places[k] = std::max(each[k].count, 1) - fromEnd;
    }
    paths.place(places, codes);
    for (size_t k = 0; k < columns.size(); ++k)
      ASSERT_EQ(codes[k], depthCodeOnPath(each[k], places[k], grid.step, grid.depthStep, placement)) << k << ", " << fromEnd << " of " << each[k].count << ", step " << grid.step;
  }
}

TEST(PixelPaths, StepsAreThoseOfTheMarcher) {
  for (const float step : {1.0f, 0.5f, 0.25f, 0.1f, 0.3f, 1.0f / 3.0f, 7.7f, 1e-3f, 3e-7f, 1e-9f, 1e-30f, 0.0f, -1.0f, INFINITY, NAN}) {
    SampleFrame frame = emptyPicture(70, 50);
    frame.settings.render.step = step;
    for (const Placement placement : {Placement::steps, Placement::halfSteps, kBorders}) expectPathsOf(frame, placement);
  }
}

}  // namespace
}  // namespace warpscope
