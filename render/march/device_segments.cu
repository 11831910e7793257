// A thread a pixel copies its segments.
// See device_segments.h.
#include "render/march/device_segments.h"

#include <thrust/iterator/transform_iterator.h>
#include <cub/device/device_scan.cuh>

#include "render/cuda/check.h"
#include "render/cuda/pinned_memory.h"

namespace warpscope {
namespace {

struct NumberOf {
  __host__ __device__ uint32_t operator()(RaySegmentCount count) const { return static_cast<uint32_t>(count.count()); }
};

__global__ void __launch_bounds__(256)
    gatherSegments(size_t pixels, size_t slots, const RaySegmentCount* counts, const uint32_t* ends, SegmentSlots from, SegmentSlots to) {
  const size_t pixel = size_t{blockIdx.x} * blockDim.x + threadIdx.x;
  if (pixel >= pixels) return;
  const auto count = static_cast<uint32_t>(counts[pixel].count());
  const size_t first = ends[pixel] - count, dense = pixel * slots;
  for (uint32_t i = 0; i < count; ++i) {
    to.depths[first + i] = from.depths[dense + i];
    to.colors[first + i] = from.colors[dense + i];
    if (from.normals != nullptr) to.normals[first + i] = from.normals[dense + i];
  }
}

template <class T>
void copyToHost(TransferVector<T>& to, const cuda::DeviceBuffer<T>& from, size_t count, cuda::Stream& stream) {
  to = TransferVector<T>(TransferAllocator<T>(cuda::pinnedMemory()));
  to.resize(count);
  WARPSCOPE_CUDA_CHECK(cudaMemcpyAsync(to.data(), from.data(), count * sizeof(T), cudaMemcpyDeviceToHost, stream));
}

}  // namespace

void DeviceSegments::reserve(size_t pixels, int slots, bool hasNormals) {
  pixels_ = pixels;
  slots_ = slots;
  hasNormals_ = hasNormals;
  if (slots == 0) return;
  counts_.reserve(pixels);
  ends_.reserve(pixels);
  for (Buffers* buffers : {&dense_, &kept_}) {
    buffers->depths.reserve(pixels * static_cast<size_t>(slots));
    buffers->colors.reserve(pixels * static_cast<size_t>(slots));
    if (hasNormals) buffers->normals.reserve(pixels * static_cast<size_t>(slots));
  }
}

void DeviceSegments::clear(cuda::Stream& stream) {
  if (slots_ > 0) WARPSCOPE_CUDA_CHECK(cudaMemsetAsync(counts_.data(), 0, pixels_ * sizeof(RaySegmentCount), stream));
}

void DeviceSegments::compact(cuda::Stream& stream) {
  if (slots_ == 0) return;
  const auto numbers = thrust::make_transform_iterator(counts_.data(), NumberOf{});
  cuda::withScratch(scratch_, [&](void* memory, size_t& bytes) {
    return cub::DeviceScan::InclusiveSum(memory, bytes, numbers, ends_.data(), static_cast<int64_t>(pixels_), stream);
  });
  constexpr unsigned kThreads = 256;
  const SegmentSlots from{dense_.depths.data(), dense_.colors.data(), hasNormals_ ? dense_.normals.data() : nullptr};
  const SegmentSlots to{kept_.depths.data(), kept_.colors.data(), hasNormals_ ? kept_.normals.data() : nullptr};
  gatherSegments<<<cuda::blocksFor(pixels_, kThreads), kThreads, 0, stream>>>(pixels_, static_cast<size_t>(slots_), counts_.data(), ends_.data(), from, to);
  WARPSCOPE_CUDA_CHECK_LAUNCH();
}

void DeviceSegments::copyTo(FrameSegments& segments, cuda::Stream& stream) {
  segments = {};
  if (slots_ == 0) return;
  uint32_t count = 0;
  WARPSCOPE_CUDA_CHECK(cudaMemcpyAsync(&count, ends_.data() + (pixels_ - 1), sizeof count, cudaMemcpyDeviceToHost, stream));
  copyToHost(segments.rays, counts_, pixels_, stream);
  stream.synchronize();
  copyToHost(segments.depths, kept_.depths, count, stream);
  copyToHost(segments.colors, kept_.colors, count, stream);
  if (hasNormals_) copyToHost(segments.normals, kept_.normals, count, stream);
  stream.synchronize();
}

}  // namespace warpscope
