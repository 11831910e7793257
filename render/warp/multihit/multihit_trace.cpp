// Tiles of the packet traversal, each pixel's colours composited from front to back.
// See multihit_trace.h.
#include "render/warp/multihit/multihit_trace.h"

#include <stdexcept>
#include <string>

#include "render/core/parallel.h"
#include "render/warp/lbvh/tile_tracer.h"

namespace warpscope {
namespace {

template <int Capacity>
void traceTiles(const GroupedLbvhView& view, std::span<const Rgba8> colors, const Camera& camera, int hits, Image<uint32_t>& ids,
                Image<glm::vec4>& color, const std::stop_token& stop) {
  const ColorTables& tables = ColorTables::instance();
  const PacketScene scene = makePacketScene(view, camera);
  parallelForTiles(camera.width, camera.height, kTileSide, stop, [&](uint32_t x0, uint32_t y0, uint32_t x1, uint32_t y1) {
    TileTracer<Capacity> tile(scene, hits, x0, y0, x1, y1);
    tile.trace();
    for (uint32_t y = y0; y < y1; ++y)
      for (uint32_t x = x0; x < x1; ++x) {
        const uint32_t nearest = tile.id(0, x, y);
        ids(x, y) = nearest;
        glm::vec4 sum = nearest == kNoSample ? glm::vec4(0.0f) : tables.decode(colors[nearest]);
        for (int hit = 1; hit < hits; ++hit) {
          const uint32_t id = tile.id(hit, x, y);
          if (id == kNoSample) break;
          sum = over(sum, tables.decode(colors[id]));
        }
        color(x, y) = sum;
      }
  });
}

}  // namespace

void traceNearestHits(const GroupedLbvhView& view, std::span<const Rgba8> colors, const Camera& camera, int hits, Image<uint32_t>& ids,
                      Image<glm::vec4>& color, const std::stop_token& stop) {
  if (hits < 1 || hits > kMaxHits)
    throw std::invalid_argument("hits must be 1 to " + std::to_string(kMaxHits) + ", not " + std::to_string(hits));
  if (colors.size() != view.count)
    throw std::invalid_argument(std::to_string(colors.size()) + " colours for " + std::to_string(view.count) + " spheres");
  if (view.count == 0) {
    ids.resize(camera.width, camera.height, kNoSample);
    color.resize(camera.width, camera.height);
    return;
  }
  ids.reshape(camera.width, camera.height);
  color.reshape(camera.width, camera.height);
  // Of small lists more fit into the caches.
  const auto trace = hits <= 4 ? traceTiles<4> : traceTiles<kMaxHits>;
  trace(view, colors, camera, hits, ids, color, stop);
}

}  // namespace warpscope
