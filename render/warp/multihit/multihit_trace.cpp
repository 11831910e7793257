// Tiles of the packet traversal: pieces of all of a tile's rays, then wide spheres of those that met none.
// See multihit_trace.h.
#include "render/warp/multihit/multihit_trace.h"

#include <stdexcept>
#include <string>

#include "render/core/parallel.h"
#include "render/march/own_picture.h"
#include "render/warp/lbvh/tile_tracer.h"

namespace warpscope {
namespace {

/// A sphere, and the frustum of its pixel.
struct PreparedPiece {
  SeenSphere sphere;
  PixelFrustum frustum;
};

/// What lies of spheres in their pixels, for TileTracer.
struct PieceIntersection {
  const PackedSample* samples = nullptr;
  const PixelGrid* pixels = nullptr;
  glm::vec3 origin{0.0f};  ///< from the frame's eye to that of the rays
};

PreparedPiece preparedFor(const PieceIntersection& pieces, uint32_t id, const glm::vec3& toCenter, float radius) {
  return {seenSphere(toCenter, radius), frustumOf(*pieces.pixels, pieces.samples[id], pieces.origin)};
}

/// pieceDistance() of many rays, by the same operations in the same order.
FloatPack intersectPack(const PieceIntersection&, const Vec3Pack& direction, const glm::vec3& toCenter, const PreparedPiece& piece) {
  const FloatPack noHit(kNoHit), zero(0.0f);
  const FloatPack entry = intersectSpherePack(direction, toCenter, piece.sphere);
  if (xsimd::none(entry < noHit)) return noHit;
  // Where lanes miss, infinity is subtracted from, and numbers are divided by 0.
  return exceptionsExpected([&] {
    const FloatPack along = toCenter.x * direction.x + toCenter.y * direction.y + toCenter.z * direction.z;
    FloatPack begin = entry, end = 2.0f * along - entry;
    for (int k = 0; k < 4; ++k) {
      const glm::vec3& normal = piece.frustum.normal[k];
      const FloatPack rate = normal.x * direction.x + normal.y * direction.y + normal.z * direction.z;
      const FloatPack cut = FloatPack(-piece.frustum.distance[k]) / rate;
      begin = xsimd::select((rate > zero) & (cut > begin), cut, begin);
      end = xsimd::select((rate < zero) & (cut < end), cut, end);
      if (piece.frustum.distance[k] < 0.0f) end = xsimd::select(rate == zero, -noHit, end);
    }
    return FloatPack(xsimd::select((entry < noHit) & (begin <= end), along, noHit));
  });
}

/// As surfacesOf() wants a frame's samples.
struct SamplesOnHost {
  const PackedSample* samples;
  const Sphere* spheres;
  const Rgba8* colors;
  const ColorTables& tables;

  Sphere sphere(uint32_t id) const { return spheres[id]; }
  uint32_t pixel(uint32_t id) const { return pixelKey(samples[id]); }
  glm::vec4 color(uint32_t id) const { return tables.decode(colors[id]); }
};

/// The hits of a pixel's ray.
template <class Tile>
struct HitsOfPixel {
  const Tile& tile;
  uint32_t x, y;
  uint32_t id(int hit) const { return tile.id(hit, x, y); }
};

}  // namespace

void SurfaceTracer::build(const SampleFrame& frame, std::span<const Sphere> spheres) {
  wide_.build(spheres);
  firstOf_ = ownPicture(frame);
  rays_ = {frame.samples.data(), frame.layers().empty() ? nullptr : frame.layers().data(),
           firstOf_.data(),      static_cast<uint32_t>(frame.size()),
           firstOf_.width(),     firstOf_.height(),
           frame.grid()};
  samples_.resize(frame.size());
  spheres_.resize(frame.size());
  parallelForRanges(samples_.size(), 1 << 15, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      samples_[i] = withSurfaceRadius(rays_, static_cast<uint32_t>(i));
      spheres_[i] = unpackSample(samples_[i], rays_.grid);
    }
  });
  pieces_.build(spheres_);
  frame_ = &frame;
}

template <int Capacity>
void SurfaceTracer::traceTiles(const Camera& camera, int most, Image<uint32_t>& ids, Image<glm::vec4>& color, const std::stop_token& stop) const {
  const GroupedLbvhView pieces = pieces_.view(), wide = wide_.view();
  const PacketScene scene = makePacketScene(pieces, camera), wideScene = makePacketScene(wide, camera);
  const PieceIntersection intersection{samples_.data(), &rays_.grid.pixels, camera.eye - frame_->camera.eye};
  const SamplesOnHost samples{samples_.data(), spheres_.data(), frame_->colors.data(), ColorTables::instance()};
  const int count = piecesFor(most);
  const auto rayOf = [&](uint32_t x, uint32_t y) { return pixelRay(camera, {static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f}); };
  parallelForTiles(camera.width, camera.height, kTileSide, stop, [&](uint32_t x0, uint32_t y0, uint32_t x1, uint32_t y1) {
    using Tile = TileTracer<Capacity, PieceIntersection>;
    Tile tile(scene, count, x0, y0, x1, y1, intersection);
    tile.trace();
    bool hasGaps = false;
    for (uint32_t y = y0; y < y1; ++y)
      for (uint32_t x = x0; x < x1; ++x) {
        const SurfacesSeen seen = surfacesOf(samples, rayOf(x, y), HitsOfPixel<Tile>{tile, x, y}, count, most);
        ids(x, y) = seen.nearest;
        color(x, y) = seen.color;
        hasGaps = hasGaps || seen.nearest == kNoSample;
      }
    if (!hasGaps) return;
    TileTracer<1> gaps(wideScene, 1, x0, y0, x1, y1);
    for (uint32_t y = y0; y < y1; ++y)
      for (uint32_t x = x0; x < x1; ++x)
        if (ids(x, y) != kNoSample) gaps.leaveOut(x, y);
    gaps.trace();
    for (uint32_t y = y0; y < y1; ++y)
      for (uint32_t x = x0; x < x1; ++x) {
        const uint32_t id = gaps.id(0, x, y);
        if (ids(x, y) != kNoSample || id == kNoSample || isSeenEmpty(rays_, frame_->camera, rayOf(x, y).at(gaps.t(0, x, y)))) continue;
        ids(x, y) = id;
        color(x, y) = samples.color(id);
      }
  });
}

void SurfaceTracer::trace(const Camera& camera, int most, Image<uint32_t>& ids, Image<glm::vec4>& color, const std::stop_token& stop) const {
  if (most < 1 || most > kMaxHits) throw std::invalid_argument("hits must be 1 to " + std::to_string(kMaxHits) + ", not " + std::to_string(most));
  if (samples_.empty()) {
    ids.resize(camera.width, camera.height, kNoSample);
    color.resize(camera.width, camera.height);
    return;
  }
  ids.reshape(camera.width, camera.height);
  color.reshape(camera.width, camera.height);
  // Of small lists more fit into the caches.
  if (piecesFor(most) <= 6)
    traceTiles<6>(camera, most, ids, color, stop);
  else
    traceTiles<kMaxHits>(camera, most, ids, color, stop);
}

}  // namespace warpscope
