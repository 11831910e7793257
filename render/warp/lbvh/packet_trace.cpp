// Tiles in parallel.
// See packet_trace.h and tile_tracer.h.
#include "render/warp/lbvh/packet_trace.h"

#include "render/core/parallel.h"
#include "render/warp/lbvh/tile_tracer.h"

namespace warpscope {

void tracePackets(const GroupedLbvhView& view, const Camera& camera, Image<uint32_t>& ids, Image<float>* depth,
                  const std::stop_token& stop, Arithmetic arithmetic) {
  ids.resize(camera.width, camera.height, kNoSample);
  if (depth) depth->resize(camera.width, camera.height, kNoHit);
  if (view.count == 0) return;
  const PacketScene scene = makePacketScene(view, camera);
  const auto traceBy = [&]<class Intersection>(const Intersection& intersection) {
    parallelForTiles(camera.width, camera.height, kTileSide, stop,
                     [&](uint32_t x0, uint32_t y0, uint32_t x1, uint32_t y1) {
                       TileTracer<1, Intersection> tile(scene, 1, x0, y0, x1, y1, intersection);
                       tile.trace();
                       for (uint32_t y = y0; y < y1; ++y)
                         for (uint32_t x = x0; x < x1; ++x) {
                           ids(x, y) = tile.id(0, x, y);
                           if (depth) (*depth)(x, y) = tile.t(0, x, y);
                         }
                     });
  };
  if (view.halfLines != nullptr)
    traceBy(CapsuleIntersection{view.halfLines});
  else
    visitSphereArithmetic(arithmetic, traceBy);
}

}  // namespace warpscope
