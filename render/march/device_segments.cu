// A thread a pixel copies its segments.
// See device_segments.h.
#include "render/march/device_segments.h"

#include <thrust/iterator/transform_iterator.h>
#include <cub/device/device_scan.cuh>

#include "render/cuda/check.h"

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

}  // namespace

void DeviceSegments::reserve(size_t pixels, int slots, bool hasNormals, CudaFrameBuffers& frame) {
  pixels_ = pixels;
  slots_ = slots;
  hasNormals_ = hasNormals;
  if (slots == 0) return;
  const size_t places = pixels * static_cast<size_t>(slots);
  frame.rays.reserve(pixels);
  frame.ends.reserve(pixels);
  for (auto* depths : {&depths_, &frame.depths}) depths->reserve(places);
  for (auto* colors : {&colors_, &frame.segmentColors}) colors->reserve(places);
  if (!hasNormals) return;
  for (auto* normals : {&normals_, &frame.normals}) normals->reserve(places);
}

void DeviceSegments::clear(CudaFrameBuffers& frame, cuda::Stream& stream) {
  if (slots_ > 0) WARPSCOPE_CUDA_CHECK(cudaMemsetAsync(frame.rays.data(), 0, pixels_ * sizeof(RaySegmentCount), stream));
}

void DeviceSegments::compact(CudaFrameBuffers& frame, uint32_t* count, cuda::Stream& stream) {
  if (slots_ == 0) return;
  const auto numbers = thrust::make_transform_iterator(frame.rays.data(), NumberOf{});
  cuda::withScratch(scratch_, [&](void* memory, size_t& bytes) {
    return cub::DeviceScan::InclusiveSum(memory, bytes, numbers, frame.ends.data(), static_cast<int64_t>(pixels_), stream);
  });
  constexpr unsigned kThreads = 256;
  const SegmentSlots from{depths_.data(), colors_.data(), hasNormals_ ? normals_.data() : nullptr};
  const SegmentSlots to{frame.depths.data(), frame.segmentColors.data(), hasNormals_ ? frame.normals.data() : nullptr};
  gatherSegments<<<cuda::blocksFor(pixels_, kThreads), kThreads, 0, stream>>>(pixels_, static_cast<size_t>(slots_), frame.rays.data(), frame.ends.data(), from, to);
  WARPSCOPE_CUDA_CHECK_LAUNCH();
  WARPSCOPE_CUDA_CHECK(cudaMemcpyAsync(count, frame.ends.data() + (pixels_ - 1), sizeof(uint32_t), cudaMemcpyDeviceToHost, stream));
}

}  // namespace warpscope
