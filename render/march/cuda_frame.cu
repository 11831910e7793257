// See cuda_frame.h.
#include "render/march/cuda_frame.h"

#include "render/cuda/pinned_memory.h"
#include "render/march/compact.h"

namespace warpscope {
namespace {

/// In stream order; the vector has its size at once.
template <class T, class Held>
void fetch(TransferVector<T>& to, const cuda::DeviceBuffer<Held>& from, size_t count, cudaStream_t stream) {
  to = TransferVector<T>(TransferAllocator<T>(cuda::pinnedMemory()));
  to.resize(count * sizeof(Held) / sizeof(T));
  if (count > 0) WARPSCOPE_CUDA_CHECK(cudaMemcpyAsync(to.data(), from.data(), count * sizeof(Held), cudaMemcpyDeviceToHost, stream));
}

constexpr unsigned kThreads = 256;
constexpr uint32_t kNoPixel = ~0u;

/// A thread for each pixel that is looked at.
__global__ void __launch_bounds__(kThreads)
    findFirstSegments(size_t count, size_t stride, const RaySegmentCount* rays, const uint32_t* ends, const SegmentDepths* depths, FirstSegment* first) {
  const size_t i = size_t{blockIdx.x} * kThreads + threadIdx.x;
  if (i >= count) return;
  const size_t pixel = i * stride;
  const int own = rays[pixel].count();
  first[i] = own > 0 ? FirstSegment{static_cast<uint32_t>(pixel), depths[ends[pixel] - static_cast<uint32_t>(own)].begin} : FirstSegment{kNoPixel, 0};
}

}  // namespace

TransferVector<FirstSegment> CudaFrame::firstSegments(size_t stride) const {
  const size_t count = (sizes_.rays + stride - 1) / stride;
  CudaFrameBuffers& held = buffers();
  TransferVector<FirstSegment> first;
  if (count == 0 || sizes_.segments == 0) return first;
  const cuda::Settled settled(memory_->stream);
  memory_->probes.reserve(count);
  findFirstSegments<<<cuda::blocksFor(count, kThreads), kThreads, 0, memory_->stream>>>(count, stride, held.rays.data(), held.ends.data(), held.depths.data(), memory_->probes.data());
  WARPSCOPE_CUDA_CHECK_LAUNCH();
  fetch(first, memory_->probes, count, memory_->stream);
  memory_->stream.synchronize();
  std::erase_if(first, [](const FirstSegment& segment) { return segment.pixel == kNoPixel; });
  return first;
}

TransferVector<PackedSample> CudaFrame::everySample(size_t stride) const {
  const size_t count = (sizes_.samples + stride - 1) / stride;
  TransferVector<PackedSample> samples{TransferAllocator<PackedSample>(cuda::pinnedMemory())};
  samples.resize(count);
  if (count == 0) return samples;
  constexpr size_t kBytes = sizeof(PackedSample);
  const cuda::Stream& stream = memory_->stream;
  WARPSCOPE_CUDA_CHECK(cudaMemcpy2DAsync(samples.data(), kBytes, buffers().samples.data(), stride * kBytes, kBytes, count, cudaMemcpyDeviceToHost, stream));
  stream.synchronize();
  return samples;
}

void CudaFrame::copyTo(SampleFrame& frame) const {
  cuda::Event copied;
  copyTo(frame, memory_->stream, copied);
}

void CudaFrame::copyTo(SampleFrame& frame, cudaStream_t stream, cuda::Event& copied) const {
  CudaFrameBuffers& from = buffers();
  TransferVector<std::byte> layers, spreads;
  const cuda::Settled settled(stream);
  fetch(frame.samples, from.samples, sizes_.samples, stream);
  fetch(frame.colors, from.colors, sizes_.samples, stream);
  frame.segments = {};
  if (sizes_.rays > 0) {
    fetch(frame.segments.rays, from.rays, sizes_.rays, stream);
    fetch(frame.segments.depths, from.depths, sizes_.segments, stream);
    fetch(frame.segments.colors, from.segmentColors, sizes_.segments, stream);
    if (sizes_.hasNormals) fetch(frame.segments.normals, from.normals, sizes_.segments, stream);
  }
  if (sizes_.hasLayers) fetch(layers, from.layers, sizes_.samples, stream);
  if (sizes_.hasSpreads) fetch(spreads, from.spreads, sizes_.samples, stream);
  copied.record(stream);
  copied.synchronize();
  setLayers(std::move(layers), frame);
  if (sizes_.hasSpreads) setSpreads(std::move(spreads), frame);
}

}  // namespace warpscope
