// The nearest hits, and what they are of.
// See device_splats.h.
#include "render/warp/splats/device_splats.h"

namespace warpscope {
namespace {

constexpr unsigned kSplatThreads = 256;

__global__ void resolveNearest(const HitPlanes nearest, uint32_t width, uint32_t* ids, float* depth) {
  const uint32_t i = blockIdx.x * kSplatThreads + threadIdx.x;
  if (i >= width * nearest.height) return;
  const KeptHit hit = nearest.hits[nearest.at(i % width, i / width)];
  ids[i] = hit == kNoKeptHit ? kNoSample : static_cast<uint32_t>(hit);
  if (depth != nullptr) depth[i] = hit == kNoKeptHit ? kNoHit : __uint_as_float(static_cast<uint32_t>(hit >> 32));
}

}  // namespace

void DeviceSplats::draw(const DeviceFrameView& frame, const Camera& camera, uint32_t* ids, float* depth, cudaStream_t stream) {
  HitPlanes planes = planesFor(camera);
  nearest_.reserve(planes.size());
  planes.hits = nearest_.data();
  WARPSCOPE_CUDA_CHECK(cudaMemsetAsync(planes.hits, 0xff, planes.size() * sizeof(KeptHit), stream));
  walk_.walk(NearestOfSpheres{}, frame, camera, planes, {}, stream);
  resolveNearest<<<cuda::blocksFor(size_t{camera.width} * camera.height, kSplatThreads), kSplatThreads, 0, stream>>>(planes, camera.width, ids, depth);
  WARPSCOPE_CUDA_CHECK_LAUNCH();
}

}  // namespace warpscope
