// Tiles of segments on all cores.
// See tiled_segments.h.
#include "render/codec/tiled/tiled_segments.h"

#include <algorithm>
#include <atomic>

#include "render/base/shared_pool.h"
#include "render/codec/segment_coding.h"
#include "render/codec/summed_hash.h"
#include "render/codec/tiled/tile_segments.h"
#include "render/core/parallel.h"

namespace warpscope {
namespace {

uint64_t summedHashOf(const FrameSegments& segments) {
  const SegmentDepths* const depths = segments.depths.data();
  const NormalCode* const normals = segments.normals.data();
  const RaySegmentCount* const rays = segments.rays.data();
  const size_t pixels = segments.rays.size(), count = segments.size();
  return summedHash(pixels, 0, [rays](size_t i) { return uint64_t{rays[i].bits()}; }) +
         summedHash(count, pixels, [depths](size_t i) { return depths[i].begin | uint64_t{depths[i].end} << 32; }) +
         summedHash(segments.normals.size(), pixels + count, [normals](size_t i) { return uint64_t{normals[i]}; });
}

/// How many segments each row of a tile has.
void countRows(const SampleFrame& frame, const TileRect& rect, std::span<RowPart> rows) {
  for (uint32_t y = 0; y < rect.height; ++y) {
    const RaySegmentCount* const rays = frame.segments.rays.data() + size_t{rect.y0 + y} * frame.camera.width + rect.x0;
    uint32_t count = 0;
    for (uint32_t x = 0; x < rect.width; ++x) count += static_cast<uint32_t>(rays[x].count());
    rows[y].end = count;
  }
}

}  // namespace

struct TiledSegments::Buffers {
  TileRows rows;
  std::vector<SheetTile> tiles;
  SheetReader sheet;
  std::vector<AnsReader> streams;
  const std::shared_ptr<SharedPool<TileSegments>> pool = SharedPool<TileSegments>::ofProcess();
};

TiledSegments::TiledSegments() : buffers_(std::make_unique<Buffers>()) {}
TiledSegments::~TiledSegments() { buffers_->pool->forget(); }

uint64_t mostTiledSegmentBytes(const Camera& camera, uint64_t segments, uint64_t layers) {
  const uint64_t pixels = uint64_t{camera.width} * camera.height;
  return sizeof(uint64_t) + mostSheetBytes(segmentForm(true), {camera.width, camera.height}, pixels, segments, layers);
}

void TiledSegments::append(ByteVector& out, const SampleFrame& frame, Placement placement) {
  Buffers& b = *buffers_;
  const TileGrid grid{frame.camera.width, frame.camera.height};
  b.rows.begin(grid);
  parallelForRanges(grid.count(), 1, [&](size_t begin, size_t end) {
    for (size_t tile = begin; tile < end; ++tile) countRows(frame, grid.at(static_cast<uint32_t>(tile)), b.rows.of(tile));
  });
  b.rows.place();
  b.tiles.resize(grid.count());
  parallelForRanges(grid.count(), 1, [&](size_t begin, size_t end) {
    const auto work = b.pool->take();
    for (size_t tile = begin; tile < end; ++tile) work->pack(frame, placement, grid.at(static_cast<uint32_t>(tile)), b.rows.of(tile), b.tiles[tile]);
  });
  appendLittle(out, summedHashOf(frame.segments));
  appendSheet(out, segmentForm(!frame.segments.normals.empty()), b.tiles);
}

DecodeError TiledSegments::take(ByteReader& reader, Placement placement, bool hasNormals, size_t most, SampleFrame& frame) {
  Buffers& b = *buffers_;
  FrameSegments& segments = frame.segments;
  const TileGrid grid{frame.camera.width, frame.camera.height};
  const auto hash = reader.take<uint64_t>();
  const int layers = frame.settings.sample.segments;
  if (DecodeError error = b.sheet.begin(reader, segmentForm(hasNormals), grid.count(), static_cast<uint32_t>(std::clamp(layers, 0, static_cast<int>(kSegmentsRange.highest)))))
    return error;
  segments.rays.resize(size_t{grid.width} * grid.height);
  b.rows.begin(grid);
  b.streams.resize(grid.count());
  std::atomic<bool> isDamaged = false;
  parallelForRanges(grid.count(), 1, [&](size_t begin, size_t end) {
    const auto work = b.pool->take();
    for (size_t tile = begin; tile < end; ++tile) {
      const TileRect rect = grid.at(static_cast<uint32_t>(tile));
      if (!work->takeRays(b.sheet, static_cast<uint32_t>(tile), rect, layers, b.streams[tile], frame)) isDamaged = true;
      countRows(frame, rect, b.rows.of(tile));
    }
  });
  if (isDamaged) return "what rays have of segments is damaged";
  const size_t count = b.rows.place();
  if (count > most) return "the frame has more segments than are allowed";
  segments.depths.resize(count);
  segments.colors.resize(count);
  segments.normals.resize(hasNormals ? count : 0);
  parallelForRanges(grid.count(), 1, [&](size_t begin, size_t end) {
    const auto work = b.pool->take();
    for (size_t tile = begin; tile < end; ++tile)
      if (!work->unpack(b.sheet, static_cast<uint32_t>(tile), grid.at(static_cast<uint32_t>(tile)), b.rows.of(tile), placement, b.streams[tile], frame)) isDamaged = true;
  });
  if (isDamaged) return "a tile of segments is damaged";
  if (summedHashOf(segments) != hash) return kOtherSegments;
  return whyInconsistentSegments(frame);
}

}  // namespace warpscope
