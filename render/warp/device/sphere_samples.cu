// One block picks them.
// See sphere_samples.h.
#include "render/warp/device/sphere_samples.h"

#include <algorithm>

#include "render/cuda/memory.h"

namespace warpscope {
namespace {

constexpr unsigned kSphereThreads = 256;

__global__ void __launch_bounds__(kSphereThreads) pick(const PackedSample* samples, const uint32_t* places, unsigned count, PackedSample* picked) {
  for (unsigned i = threadIdx.x; i < count; i += kSphereThreads) picked[i] = samples[places[i]];
}

}  // namespace

SphereLoadProbe SphereSamples::probeOf(const SampleFrame& frame, const DeviceFrameView& there, cudaStream_t stream) {
  if (!frame.isAway) return SphereLoadProbe(frame);
  const std::vector<uint32_t> places = sphereProbes(there.count);
  places_.assign(places.begin(), places.end());
  samples_.resize(places.size());
  if (!places.empty()) {
    pick<<<1, kSphereThreads, 0, stream>>>(there.samples, places_.data(), static_cast<unsigned>(places.size()), samples_.data());
    WARPSCOPE_CUDA_CHECK_LAUNCH();
    WARPSCOPE_CUDA_CHECK(cudaStreamSynchronize(stream));
  }
  return SphereLoadProbe(there.count, samples_, there.grid);
}

}  // namespace warpscope
