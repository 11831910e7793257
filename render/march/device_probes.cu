// See device_probes.h.
#include "render/march/device_probes.h"

namespace warpscope {
namespace {

constexpr unsigned kThreads = 256;
constexpr uint32_t kNoPixel = ~0u;  // of a ray without segments
static_assert(kMostFrameProbes % kThreads == 0);

/// A thread for each that there may be.
__global__ void __launch_bounds__(kThreads) findProbes(const PackedSample* samples, const uint32_t* sampleCount, PackedSample* found) {
  const size_t i = size_t{blockIdx.x} * kThreads + threadIdx.x, at = i * probeStride(*sampleCount);
  if (at < *sampleCount) found[i] = samples[at];
}

__global__ void __launch_bounds__(kThreads)
    findSegmentProbes(size_t rays, const RaySegmentCount* counts, const uint32_t* ends, const SegmentDepths* depths, FirstSegment* found) {
  const size_t i = size_t{blockIdx.x} * kThreads + threadIdx.x, pixel = i * probeStride(rays);
  if (pixel >= rays) return;
  const int own = counts[pixel].count();
  found[i] = own > 0 ? FirstSegment{static_cast<uint32_t>(pixel), depths[ends[pixel] - static_cast<uint32_t>(own)].begin} : FirstSegment{kNoPixel, 0};
}

/// How many there are of so many.
size_t probesOf(size_t count) { return (count + probeStride(count) - 1) / probeStride(count); }

}  // namespace

void DeviceProbes::ask(const CudaFrameBuffers& frame, const uint32_t* sampleCount, size_t rays, cudaStream_t stream) {
  constexpr unsigned kBlocks = kMostFrameProbes / kThreads;
  findProbes<<<kBlocks, kThreads, 0, stream>>>(frame.samples.data(), sampleCount, found_.data()->samples);
  WARPSCOPE_CUDA_CHECK_LAUNCH();
  if (rays == 0) return;
  findSegmentProbes<<<kBlocks, kThreads, 0, stream>>>(rays, frame.rays.data(), frame.ends.data(), frame.depths.data(), found_.data()->segments);
  WARPSCOPE_CUDA_CHECK_LAUNCH();
}

void DeviceProbes::giveTo(CudaFrame& frame) const {
  const CudaFrameSizes& sizes = frame.sizes();
  std::vector<PackedSample> samples(found_->samples, found_->samples + probesOf(sizes.samples));
  std::vector<FirstSegment> segments;
  for (size_t i = 0; i < probesOf(sizes.rays); ++i)
    if (found_->segments[i].pixel != kNoPixel) segments.push_back(found_->segments[i]);
  frame.setProbes(std::move(samples), std::move(segments));
}

}  // namespace warpscope
