// See device_probes.h.
#include "render/march/device_probes.h"

namespace warpscope {
namespace {

constexpr unsigned kProbeThreads = kMostFrameProbes;  // one for each that there may be

/// Of how many threads of the block that is so.
__device__ uint32_t votesFor(bool is) { return static_cast<uint32_t>(__syncthreads_count(is)); }

__global__ void __launch_bounds__(kProbeThreads) lookAtSamples(PathGrid paths, const PackedSample* samples, const uint32_t* sampleCount, SampleVotes* votes) {
  const size_t count = *sampleCount, at = threadIdx.x * probeStride(count);
  const bool isThere = at < count;
  bool isOnStep = false, isOnHalfStep = false;
  if (isThere) {
    const PackedSample sample = samples[at];
    const PixelPath path = paths.path(columnOf(sample), rowOf(sample));
    isOnStep = isOnLattice(path, depthCode(sample), paths.step, paths.depthStep, false);
    isOnHalfStep = isOnLattice(path, depthCode(sample), paths.step, paths.depthStep, true);
  }
  const SampleVotes all{votesFor(isThere), votesFor(isOnStep), votesFor(isOnHalfStep)};
  if (threadIdx.x == 0) *votes = all;
}

__global__ void __launch_bounds__(kProbeThreads)
    lookAtSegments(PathGrid paths, uint32_t width, size_t rays, const RaySegmentCount* counts, const uint32_t* ends, const SegmentDepths* depths, BorderVotes* votes) {
  const size_t pixel = threadIdx.x * probeStride(rays);
  const auto own = pixel < rays ? static_cast<uint32_t>(counts[pixel].count()) : 0;
  bool isNear = false;
  if (own > 0) {
    const PixelPath path = paths.path(static_cast<uint32_t>(pixel) % width, static_cast<uint32_t>(pixel) / width);
    isNear = isNearBorder(path, depths[ends[pixel] - own].begin, paths.step, paths.depthStep);
  }
  const BorderVotes all{votesFor(own > 0), votesFor(isNear)};
  if (threadIdx.x == 0) *votes = all;
}

}  // namespace

void DeviceProbes::ask(const PathGrid& paths, uint32_t width, const CudaFrameBuffers& frame, const uint32_t* sampleCount, size_t rays, cudaStream_t stream) {
  lookAtSamples<<<1, kProbeThreads, 0, stream>>>(paths, frame.samples.data(), sampleCount, &votes_.data()->samples);
  WARPSCOPE_CUDA_CHECK_LAUNCH();
  if (rays == 0) return;
  lookAtSegments<<<1, kProbeThreads, 0, stream>>>(paths, width, rays, frame.rays.data(), frame.ends.data(), frame.depths.data(), &votes_.data()->borders);
  WARPSCOPE_CUDA_CHECK_LAUNCH();
}

FramePlacements DeviceProbes::placements(size_t segments) const {
  return {votes_->samples.placement(), segments > 0 ? votes_->borders.placement() : Placement::depth};
}

}  // namespace warpscope
