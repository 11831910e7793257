// Tiles on all cores.
// See tiled_codec.h.
#include "render/codec/tiled/tiled_codec.h"

#include <algorithm>
#include <atomic>
#include <numeric>

#include "render/base/shared_pool.h"
#include "render/codec/packed_codec.h"
#include "render/codec/plane_coding.h"
#include "render/codec/tiled/tile_samples.h"
#include "render/core/parallel.h"

namespace warpscope {
namespace {

constexpr size_t kHeadBytes = 1 + sizeof(uint64_t);
constexpr size_t kHashGrain = size_t{1} << 16;  // samples

uint64_t hashOf(std::span<const PackedSample> samples) {
  std::atomic<uint64_t> sum = 0;
  parallelForRanges(samples.size(), kHashGrain, [&](size_t begin, size_t end) {
    const PackedSample* const sample = samples.data();
    uint64_t own = 0;
    for (size_t i = begin; i < end; ++i) own += placedHash(sample[i], i);
    sum += own;
  });
  return sum;
}

size_t mostLayersOf(const SampleFrame& frame) {
  if (frame.plane(kLayerPlane) == nullptr) return 1;
  return static_cast<size_t>(std::clamp(static_cast<double>(frame.settings.sample.samplesPerRay), kSamplesPerRayRange.lowest, kSamplesPerRayRange.highest));
}

class TiledCodec final : public Codec {
 public:
  ~TiledCodec() override { pool_->forget(); }

  void encode(const SampleFrame& frame, const CodecSettings&, std::vector<std::byte>& payload) override {
    const TileGrid grid = gridOf(frame, frame.size());
    const Placement placement = placementOf(frame);
    cut(frame, grid);
    tiles_.resize(grid.count());
    parallelForRanges(grid.count(), 1, [&](size_t begin, size_t end) {
      const auto work = pool_->take();
      for (size_t tile = begin; tile < end; ++tile)
        work->pack(frame, placement, grid.at(static_cast<uint32_t>(tile)), rows_.of(tile), tiles_[tile]);
    });
    appendLittle(payload, static_cast<uint8_t>(placement));
    appendLittle(payload, hashOf(frame.samples));
    appendSheet(payload, sampleForm(!frame.layers().empty()), tiles_);
  }

  DecodeError decode(std::span<const std::byte> bytes, size_t count, SampleFrame& frame) override {
    ByteReader reader(bytes);
    const auto placement = static_cast<Placement>(reader.take<uint8_t>());
    const auto hash = reader.take<uint64_t>();
    if (reader.ranOut()) return "the tiled payload ends before its head does";
    if (static_cast<uint32_t>(placement) >= kPlacements) return "the tiled payload places samples in an unknown way";
    if (placement != Placement::depth && !hasLattice(frame)) return "the tiled payload needs a usable camera and step";
    const TileGrid grid = gridOf(frame, count);
    SamplePlane* plane = nullptr;
    for (SamplePlane& each : frame.planes)
      if (isImplied(each)) plane = &each;
    const bool hasLayers = plane != nullptr;
    const auto mostLayers = static_cast<uint32_t>(mostLayersOf(frame));
    if (DecodeError error = sheet_.begin(reader, sampleForm(hasLayers), grid.count(), mostLayers)) return error;

    counts_.resize(size_t{grid.count()} * kTileWidth * kTileHeight);
    streams_.resize(grid.count());
    rows_.begin(grid);
    std::atomic<bool> isDamaged = false;
    parallelForRanges(grid.count(), 1, [&](size_t begin, size_t end) {
      const auto work = pool_->take();
      for (size_t tile = begin; tile < end; ++tile) {
        const TileRect rect = grid.at(static_cast<uint32_t>(tile));
        const std::span<uint8_t> counts = countsOf(tile, rect);
        if (!work->takeShapes(sheet_, static_cast<uint32_t>(tile), rect, hasLayers, mostLayers, streams_[tile], counts)) isDamaged = true;
        for (uint32_t y = 0; y < rect.height; ++y) {
          const std::span<const uint8_t> row = counts.subspan(size_t{y} * rect.width, rect.width);
          rows_.of(tile)[y].end = std::accumulate(row.begin(), row.end(), 0u);
        }
      }
    });
    if (isDamaged) return "the tiles' numbers of samples are damaged";
    if (rows_.place() != count) return "the tiles of the payload have other numbers of samples than the frame";

    frame.samples.resize(count);
    frame.colors.resize(count);
    std::span<uint8_t> layers;
    if (hasLayers) {
      plane->values.resize(count);
      layers = {reinterpret_cast<uint8_t*>(plane->values.data()), count};
    }
    parallelForRanges(grid.count(), 1, [&](size_t begin, size_t end) {
      const auto work = pool_->take();
      for (size_t tile = begin; tile < end; ++tile) {
        const TileRect rect = grid.at(static_cast<uint32_t>(tile));
        if (!work->unpack(sheet_, static_cast<uint32_t>(tile), rect, countsOf(tile, rect), rows_.of(tile), placement, streams_[tile], frame, layers)) isDamaged = true;
      }
    });
    if (isDamaged) return "a tile of the payload is damaged";
    if (hashOf(frame.samples) != hash)
      return "the samples are not those that were sent: other camera or settings than the sender's, or a machine that rounds differently";
    return std::nullopt;
  }

  void encodePlane(const SampleFrame& frame, const SamplePlane& plane, std::vector<std::byte>& payload) override {
    if (!isImplied(plane)) appendPlane(payload, plane, frame.layers());
  }

  DecodeError decodePlane(std::span<const std::byte> bytes, const SampleFrame& frame, SamplePlane& plane) override {
    if (!isImplied(plane)) return takePlane(bytes, frame.size(), frame.layers(), plane);
    if (!bytes.empty()) return "the plane \"" + plane.name + "\" of a tiled payload has bytes";
    return std::nullopt;
  }

 private:
  /// No tiles without samples.
  static TileGrid gridOf(const SampleFrame& frame, size_t samples) { return samples > 0 ? TileGrid{frame.camera.width, frame.camera.height} : TileGrid{}; }

  std::span<uint8_t> countsOf(size_t tile, const TileRect& rect) { return std::span(counts_).subspan(tile * kTileWidth * kTileHeight, rect.pixels()); }

  /// Finds the samples of each row of each tile.
  void cut(const SampleFrame& frame, const TileGrid& grid) {
    rows_.begin(grid);
    const auto begin = frame.samples.begin();
    parallelForRanges(grid.count() / std::max(grid.columns(), 1u), 1, [&](size_t from, size_t to) {
      for (size_t tileRow = from; tileRow < to; ++tileRow)
        for (uint32_t y = 0; y < kTileHeight; ++y) {
          const auto row = static_cast<uint32_t>(tileRow) * kTileHeight + y;
          if (row >= grid.height) break;
          const auto firstAt = [&](auto after, uint32_t column) {
            const uint32_t key = column < grid.width ? pixelKey(column, row) : pixelKey(0, row + 1);
            return std::partition_point(after, frame.samples.end(), [key](PackedSample sample) { return pixelKey(sample) < key; });
          };
          auto at = firstAt(begin, 0);
          for (uint32_t column = 0; column < grid.columns(); ++column) {
            RowPart& own = rows_.of(tileRow * grid.columns() + column)[y];
            own.begin = static_cast<uint32_t>(at - begin);
            at = firstAt(at, (column + 1) * kTileWidth);
            own.end = static_cast<uint32_t>(at - begin);
          }
        }
    });
  }

  std::vector<SheetTile> tiles_;
  TileRows rows_;
  SheetReader sheet_;
  TransferVector<uint8_t> counts_;  // as many of each tile as the largest has pixels
  std::vector<AnsReader> streams_;
  const std::shared_ptr<SharedPool<TileSamples>> pool_ = SharedPool<TileSamples>::ofProcess();
};

}  // namespace

uint64_t mostTiledBytes(const SampleFrame& frame, uint64_t count, const CodecSettings&) {
  const TileGrid grid = count > 0 ? TileGrid{frame.camera.width, frame.camera.height} : TileGrid{};
  const uint64_t pixels = uint64_t{grid.width} * grid.height;  // a row of a tile may end within a byte
  const uint64_t masks = pixels / 8 + uint64_t{grid.columns()} * grid.height;
  return kHeadBytes + mostSheetBytes(sampleForm(frame.plane(kLayerPlane) != nullptr), grid, masks + count, count, std::min<uint64_t>(mostLayersOf(frame), count));
}

uint64_t mostTiledPlaneBytes(const SamplePlane& plane, uint64_t count) { return mostPackedPlaneBytes(plane, count); }

std::unique_ptr<Codec> makeTiledCodec() { return std::make_unique<TiledCodec>(); }

}  // namespace warpscope
