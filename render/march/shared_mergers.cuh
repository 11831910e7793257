// Segments that rays on a device merge, in shared memory: arrays that are indexed would be in local memory, a word at a time from far away.
// For .cu files.
#pragma once

#include "render/cuda/check.h"
#include "render/cuda/pixel_tiles.cuh"
#include "render/march/ray_segments.h"

namespace warpscope {

/// A thread's part of what a kernel was launched with: four words at once beside those of the other threads, so that no two of a warp are in one bank. `kRoomThere`: kRoom of mergers' memory.
template <int kRoomThere = 0>
class SharedMergerMemory {
 public:
  static constexpr int kRoom = kRoomThere;
  static constexpr size_t bytesFor(int room) { return static_cast<size_t>(room) * kPlaceBytes; }

  __device__ SharedMergerMemory() {
    extern __shared__ float4 mergerPlaces[];
    first_ = reinterpret_cast<char*>(mergerPlaces) + threadIdx.x * sizeof(float4);
    costs_ = reinterpret_cast<char*>(mergerPlaces) + kCostsAt + threadIdx.x * sizeof(uint32_t);
  }

  __device__ RaySegment segment(int i) const {
    const auto* const at = reinterpret_cast<const float4*>(first_ + i * kPlaceBytes);
    const float4 where = at[0], what = at[kTileBlockThreads];
    return {where.x, where.y, where.z, where.w, {what.x, what.y, what.z}};
  }
  __device__ void setSegment(int i, const RaySegment& segment) {
    auto* const at = reinterpret_cast<float4*>(first_ + i * kPlaceBytes);
    at[0] = {segment.begin, segment.end, segment.opacity, segment.through};
    at[kTileBlockThreads] = {segment.color.x, segment.color.y, segment.color.z, 0.0f};
  }
  __device__ uint32_t cost(int i) const { return *reinterpret_cast<const uint32_t*>(costs_ + i * kPlaceBytes); }
  __device__ void setCost(int i, uint32_t cost) { *reinterpret_cast<uint32_t*>(costs_ + i * kPlaceBytes) = cost; }

 private:
  static constexpr int kCostsAt = 2 * static_cast<int>(kTileBlockThreads * sizeof(float4)), kPlaceBytes = kCostsAt + static_cast<int>(kTileBlockThreads * sizeof(uint32_t));

  char* first_;
  char* costs_;
};

/// Kernels of which most is marched are compiled for the room that the usual number of segments takes: merging is an eighth faster then.
template <int kRoom = 0>
using SharedSegmentMerger = BasicSegmentMerger<SharedMergerMemory<kRoom>>;

/// Launches a kernel whose threads have a SharedSegmentMerger each, for rays of which `most` segments are wanted.
template <class... Parameters, class... Arguments>
void launchWithMergers(void (*kernel)(Parameters...), dim3 grid, cudaStream_t stream, int most, const Arguments&... arguments) {
  const size_t bytes = SharedMergerMemory<>::bytesFor(mergerRoomFor(most));
  WARPSCOPE_CUDA_CHECK(cudaFuncSetAttribute(kernel, cudaFuncAttributeMaxDynamicSharedMemorySize, static_cast<int>(bytes)));
  kernel<<<grid, kTileBlockThreads, bytes, stream>>>(arguments...);
}

}  // namespace warpscope
