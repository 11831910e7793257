// Tiles of samples on all cores.
// See tiled_samples.h.
#include "render/codec/tiled/tiled_samples.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <numeric>
#include <optional>

#include "render/base/shared_pool.h"
#include "render/codec/plane_coding.h"
#include "render/codec/tiled/tile_samples.h"
#include "render/core/parallel.h"

namespace warpscope {
namespace {

/// The first sample, of some in order, whose pixel is not in front of one.
template <class At>
At firstFrom(At begin, At end, uint32_t key) {
  return std::partition_point(begin, end, [key](PackedSample sample) { return pixelKey(sample) < key; });
}

/// Finds the samples of each row of each tile.
void cut(const SampleFrame& frame, const TileGrid& grid, TileRows& rows) {
  rows.begin(grid);
  const auto begin = frame.samples.begin(), end = frame.samples.end();
  const size_t mostLayers = mostTiledLayers(frame);
  parallelForRanges(grid.count() / std::max(grid.columns(), 1u), 1, [&](size_t from, size_t to) {
    for (size_t tileRow = from; tileRow < to; ++tileRow) {
      auto at = firstFrom(begin, end, pixelKey(0, static_cast<uint32_t>(tileRow) * kCodedTileHeight));
      for (uint32_t y = 0; y < kCodedTileHeight; ++y) {
        const auto row = static_cast<uint32_t>(tileRow) * kCodedTileHeight + y;
        if (row >= grid.height) break;
        for (uint32_t column = 0; column < grid.columns(); ++column) {
          const uint32_t x0 = column * kCodedTileWidth, width = std::min(kCodedTileWidth, grid.width - x0);
          RowPart& own = rows.of(tileRow * grid.columns() + column)[y];
          own.begin = static_cast<uint32_t>(at - begin);
          const auto most = at + std::min<std::ptrdiff_t>(end - at, static_cast<std::ptrdiff_t>(width * mostLayers));
          if (mostLayers == 1 && most - at == width && pixelKey(at[width - 1]) == pixelKey(x0 + width - 1, row))
            at += width;  // one in each pixel
          else if (at != end && pixelKey(*at) <= pixelKey(x0 + width - 1, row))
            at = firstFrom(at, most, pixelKey(x0 + width - 1, row) + 1);
          own.end = static_cast<uint32_t>(at - begin);
        }
      }
    }
  });
}

}  // namespace

struct TiledSamples::Buffers {
  std::vector<SheetTile> tiles;
  TileRows rows;
  SheetReader sheet;
  TransferVector<uint8_t> counts;  // as many of each tile as the largest has pixels
  std::vector<AnsReader> streams;
  const std::shared_ptr<SharedPool<TileSamples>> pool = SharedPool<TileSamples>::ofProcess();

  std::span<uint8_t> countsOf(size_t tile, const TileRect& rect) { return std::span(counts).subspan(tile * kCodedTileWidth * kCodedTileHeight, rect.pixels()); }
};

TiledSamples::TiledSamples() : buffers_(std::make_unique<Buffers>()) {}
TiledSamples::~TiledSamples() { buffers_->pool->forget(); }

size_t mostTiledLayers(const SampleFrame& frame) {
  if (frame.plane(kLayerPlane) == nullptr) return 1;
  return static_cast<size_t>(std::clamp(static_cast<double>(frame.settings.sample.samplesPerRay), kSamplesPerRayRange.lowest, kSamplesPerRayRange.highest));
}

TileGrid tiledGridOf(const SampleFrame& frame, size_t samples) { return samples > 0 ? TileGrid{frame.camera.width, frame.camera.height} : TileGrid{}; }

uint64_t mostTiledSampleBytes(const SampleFrame& frame, uint64_t count) {
  const TileGrid grid = tiledGridOf(frame, count);
  const uint64_t pixels = uint64_t{grid.width} * grid.height;
  const uint64_t masks = pixels / 8 + uint64_t{grid.columns()} * grid.height;  // a row of a tile may end within a byte
  return sizeof(uint64_t) + mostSheetBytes(sampleForm(frame.plane(kLayerPlane) != nullptr), grid, masks + count, count, std::min<uint64_t>(mostTiledLayers(frame), count));
}

void TiledSamples::append(ByteVector& out, const SampleFrame& frame, Placement placement) {
  Buffers& b = *buffers_;
  const TileGrid grid = tiledGridOf(frame, frame.size());
  cut(frame, grid, b.rows);
  b.tiles.resize(grid.count());
  std::atomic<uint64_t> hash = 0;
  parallelForRanges(grid.count(), 1, [&](size_t begin, size_t end) {
    const auto work = b.pool->take();
    uint64_t own = 0;
    for (size_t tile = begin; tile < end; ++tile)
      own += work->pack(frame, placement, grid.at(static_cast<uint32_t>(tile)), b.rows.of(tile), b.tiles[tile]);
    hash += own;
  });
  appendLittle(out, hash.load());
  appendSheet(out, sampleForm(std::ranges::any_of(frame.planes, isImplied)), b.tiles);
}

DecodeError TiledSamples::take(ByteReader& reader, Placement placement, size_t count, SampleFrame& frame) {
  Buffers& b = *buffers_;
  const auto hash = reader.take<uint64_t>();
  if (reader.ranOut()) return "the tiled payload ends before its head does";
  const TileGrid grid = tiledGridOf(frame, count);
  SamplePlane* plane = nullptr;
  for (SamplePlane& each : frame.planes)
    if (isImplied(each)) plane = &each;
  const bool hasLayers = plane != nullptr;
  const auto mostLayers = static_cast<uint32_t>(mostTiledLayers(frame));
  if (DecodeError error = b.sheet.begin(reader, sampleForm(hasLayers), grid.count(), mostLayers)) return error;

  b.counts.resize(size_t{grid.count()} * kCodedTileWidth * kCodedTileHeight);
  b.streams.resize(grid.count());
  b.rows.begin(grid);
  std::atomic<bool> isDamaged = false;
  parallelForRanges(grid.count(), 1, [&](size_t begin, size_t end) {
    const auto work = b.pool->take();
    for (size_t tile = begin; tile < end; ++tile) {
      const TileRect rect = grid.at(static_cast<uint32_t>(tile));
      const std::span<uint8_t> counts = b.countsOf(tile, rect);
      if (!work->takeShapes(b.sheet, static_cast<uint32_t>(tile), rect, hasLayers, mostLayers, b.streams[tile], counts)) {
        isDamaged = true;
        continue;
      }
      for (uint32_t y = 0; y < rect.height; ++y) {
        const std::span<const uint8_t> row = counts.subspan(size_t{y} * rect.width, rect.width);
        b.rows.of(tile)[y].end = std::accumulate(row.begin(), row.end(), 0u);
      }
    }
  });
  if (isDamaged) return "the tiles' numbers of samples are damaged";
  if (b.rows.place() != count) return kOtherNumbers;

  frame.samples.resize(count);
  frame.colors.resize(count);
  std::span<uint8_t> layers;
  if (hasLayers) {
    plane->values.resize(count);
    layers = {reinterpret_cast<uint8_t*>(plane->values.data()), count};
  }
  std::atomic<uint64_t> found = 0;
  parallelForRanges((grid.count() + 1) / 2, 1, [&](size_t begin, size_t end) {
    const auto work = b.pool->take();
    uint64_t own = 0;
    for (size_t pair = begin; pair < end; ++pair) {
      const std::array<uint32_t, 2> tiles{static_cast<uint32_t>(2 * pair), static_cast<uint32_t>(2 * pair + 1)};
      AnsReader none;
      std::array<AnsReader*, 2> streams{&none, &none};
      std::array<size_t, 2> sizes{};
      for (size_t i = 0; i < 2 && tiles[i] < grid.count(); ++i) {
        streams[i] = &b.streams[tiles[i]];
        const std::span<const uint8_t> counts = b.countsOf(tiles[i], grid.at(tiles[i]));
        sizes[i] = counts.size() - static_cast<size_t>(std::ranges::count(counts, uint8_t{0}));
      }
      if (!work->takeFronts(b.sheet, streams, sizes)) {
        isDamaged = true;
        continue;
      }
      for (size_t i = 0; i < 2 && tiles[i] < grid.count(); ++i) {
        const TileRect rect = grid.at(tiles[i]);
        const std::optional<uint64_t> ofTile = work->unpack(b.sheet, tiles[i], rect, b.countsOf(tiles[i], rect), b.rows.of(tiles[i]), placement, i, frame, layers);
        if (!ofTile) isDamaged = true;
        own += ofTile.value_or(0);
      }
    }
    found += own;
  });
  if (isDamaged) return "a tile of the payload is damaged";
  if (found != hash) return kOtherSamples;
  return std::nullopt;
}

}  // namespace warpscope
