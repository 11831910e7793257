// The k nearest hits of each ray, kept in registers, and their colours over each other.
// See multihit_warp_cuda.h.
#include "render/warp/multihit_warp_cuda.h"

#include <array>
#include <utility>

#include "render/warp/clusters/cluster_trace.cuh"
#include "render/warp/clusters/cluster_tree.h"
#include "render/warp/device/device_warp.h"
#include "render/warp/multihit/nearest_hits.h"
#include "render/warp/multihit_warp.h"

namespace warpscope {
namespace {

/// NearestHits as traceClusters wants them.
template <int Hits>
struct GatheredHits {
  const uint32_t* ids;
  bool isWanted;  ///< false for a pixel outside the image
  NearestHits<Hits> nearest;

  __device__ float farthest() const { return isWanted ? nearest.farthest() : -1.0f; }
  __device__ void add(uint32_t place, float t) { nearest.insert(t, ids[place]); }
};

template <int Hits>
__global__ void __launch_bounds__(kTileBlockThreads) traceHits(const __grid_constant__ ClusterTreeView tree,
                                                               const __grid_constant__ Camera camera, const Rgba8* colors,
                                                               const ColorTables* tables, DevicePixels pixels) {
  __shared__ ClusterWarpMemory memory[kTilesPerBlock];
  const PixelPlace tile = tileOfThread(0);
  if (tile.x >= camera.width || tile.y >= camera.height) return;  // the whole warp
  const PixelPlace pixel = pixelOfThread(0);
  const bool isInside = pixel.x < camera.width && pixel.y < camera.height;
  const Ray ray = rayOfPixel(camera, pixel);
  const glm::vec3 directions[1] = {ray.direction};
  GatheredHits<Hits> hits[1] = {{tree.ids, isInside, {}}};
  traceClusters(tree, camera, tile, directions, memory[threadIdx.x / 32], hits);
  if (!isInside) return;
  const size_t i = size_t{pixel.y} * camera.width + pixel.x;
  const NearestHits<Hits>& nearest = hits[0].nearest;
  pixels.samples[i] = nearest.id(0);
  glm::vec4 color = nearest.id(0) == kNoSample ? glm::vec4(0.0f) : tables->decode(colors[nearest.id(0)]);
#pragma unroll
  for (int hit = 1; hit < Hits; ++hit)
    if (nearest.id(hit) != kNoSample) color = over(color, tables->decode(colors[nearest.id(hit)]));
  pixels.color[i] = color;
}

template <int Hits>
void launch(const ClusterTreeView& tree, const Camera& camera, const Rgba8* colors, const ColorTables* tables, const DevicePixels& pixels,
            cudaStream_t stream) {
  traceHits<Hits><<<tileGrid(camera.width, camera.height), kTileBlockThreads, 0, stream>>>(tree, camera, colors, tables, pixels);
  WARPSCOPE_CUDA_CHECK_LAUNCH();
}

/// launch for 1 .. kMaxHits hits.
template <int... Hits>
constexpr auto launchesFor(std::integer_sequence<int, Hits...>) {
  return std::array{&launch<Hits + 1>...};
}
constexpr auto kLaunches = launchesFor(std::make_integer_sequence<int, kMaxHits>());

class CudaMultihitWarp final : public DeviceWarp {
 private:
  bool blends() const override { return true; }
  void build(const DeviceFrameView& frame, const WarpSettings&, cudaStream_t stream) override { clusters_.build(frame, stream); }
  void trace(const DeviceFrameView& frame, const Camera& camera, const WarpSettings& settings, const DevicePixels& pixels,
             cudaStream_t stream) override {
    kLaunches[static_cast<size_t>(settings.knobs.whole(kHitsKnob) - 1)](clusters_.view(), camera, frame.colors, colorTables(), pixels, stream);
  }

  DeviceClusterTree clusters_;
};

}  // namespace

std::unique_ptr<Warp> makeCudaMultihitWarp() { return std::make_unique<CudaMultihitWarp>(); }

}  // namespace warpscope
