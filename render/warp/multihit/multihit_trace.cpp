// One ray after the other, in small tiles for the caches' sake.
// See multihit_trace.h.
#include "render/warp/multihit/multihit_trace.h"

#include <array>
#include <stdexcept>
#include <string>
#include <utility>

#include "render/core/parallel.h"

namespace warpscope {
namespace {

constexpr uint32_t kTileSide = 16;

template <int Hits>
void traceTiles(const LbvhView& view, std::span<const Rgba8> colors, const Camera& camera, Image<uint32_t>& ids, Image<glm::vec4>& color,
                const std::stop_token& stop) {
  const ColorTables& tables = ColorTables::instance();
  parallelForTiles(camera.width, camera.height, kTileSide, stop, [&](uint32_t x0, uint32_t y0, uint32_t x1, uint32_t y1) {
    for (uint32_t y = y0; y < y1; ++y)
      for (uint32_t x = x0; x < x1; ++x) {
        const Ray ray = pixelRay(camera, {static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f});
        NearestHits<Hits> nearest;
        const bool isComplete = visitAlongRay(view, ray, nearest.farthest(), [&](uint32_t i) {
          nearest.insert(intersectSphere(ray, view.spheres[i].center, view.spheres[i].radius), view.ids[i]);
        });
        if (!isComplete) throw std::logic_error("the sphere hierarchy is deeper than its keys allow");
        ids(x, y) = nearest.id(0);
        color(x, y) = nearest.id(0) == kNoSample ? glm::vec4(0.0f) : tables.decode(colors[nearest.id(0)]);
        for (int hit = 1; hit < Hits && nearest.id(hit) != kNoSample; ++hit)
          color(x, y) = over(color(x, y), tables.decode(colors[nearest.id(hit)]));
      }
  });
}

/// traceTiles for 1 .. kMaxHits hits.
template <int... Hits>
constexpr auto tracersFor(std::integer_sequence<int, Hits...>) {
  return std::array{&traceTiles<Hits + 1>...};
}
constexpr auto kTracers = tracersFor(std::make_integer_sequence<int, kMaxHits>());

}  // namespace

void traceNearestHits(const LbvhView& view, std::span<const Rgba8> colors, const Camera& camera, int hits, Image<uint32_t>& ids,
                      Image<glm::vec4>& color, const std::stop_token& stop) {
  if (hits < 1 || hits > kMaxHits)
    throw std::invalid_argument("hits must be 1 to " + std::to_string(kMaxHits) + ", not " + std::to_string(hits));
  if (colors.size() != view.count)
    throw std::invalid_argument(std::to_string(colors.size()) + " colours for " + std::to_string(view.count) + " spheres");
  ids.reshape(camera.width, camera.height);
  color.reshape(camera.width, camera.height);
  kTracers[static_cast<size_t>(hits - 1)](view, colors, camera, ids, color, stop);
}

}  // namespace warpscope
