// Segments that rays on a device merge, in shared memory: arrays that are indexed would be in local memory, a word at a time from far away.
// For .cu files.
#pragma once

#include "render/cuda/check.h"
#include "render/cuda/pixel_tiles.cuh"
#include "render/march/ray_segments.h"

namespace warpscope {

/// A thread's part of what a kernel was launched with: a place is 32 bytes, as the least device that there are kernels for has 64 KiB for a block (compute capability 7.5). Numbers are beside
/// those of the other threads, four, two and one at a time, so that the threads that load at once are in banks of their own. `kRoomThere`: places, if that is known when compiled; 0: as the
/// merger says.
template <int kRoomThere = 0>
class SharedMergerMemory {
 public:
  static constexpr int kRoom = kRoomThere;
  static constexpr size_t bytesFor(int room) { return static_cast<size_t>(room) * kPlaceBytes; }

  __device__ SharedMergerMemory() {
    extern __shared__ float4 mergerPlaces[];
    char* const first = reinterpret_cast<char*>(mergerPlaces);
    where_ = first + threadIdx.x * sizeof(float4);
    redGreen_ = first + kRedGreenAt + threadIdx.x * sizeof(float2);
    blue_ = first + kBlueAt + threadIdx.x * sizeof(float);
  }

  __device__ RaySegment segment(int i) const {
    const float4 where = *reinterpret_cast<const float4*>(where_ + i * kPlaceBytes);
    const float2 redGreen = *reinterpret_cast<const float2*>(redGreen_ + i * kPlaceBytes);
    return {where.x, where.y, where.z, where.w, {redGreen.x, redGreen.y, *reinterpret_cast<const float*>(blue_ + i * kPlaceBytes)}};
  }
  __device__ void setSegment(int i, const RaySegment& segment) {
    static_assert(sizeof(RaySegment) == sizeof(float4) + sizeof(float2) + sizeof(float));
    *reinterpret_cast<float4*>(where_ + i * kPlaceBytes) = {segment.begin, segment.end, segment.opacity, segment.through};
    *reinterpret_cast<float2*>(redGreen_ + i * kPlaceBytes) = {segment.color.x, segment.color.y};
    *reinterpret_cast<float*>(blue_ + i * kPlaceBytes) = segment.color.z;
  }
  __device__ uint32_t cost(int i) const { return *reinterpret_cast<const uint32_t*>(blue_ + kCostBehindBlue + i * kPlaceBytes); }
  __device__ void setCost(int i, uint32_t cost) { *reinterpret_cast<uint32_t*>(blue_ + kCostBehindBlue + i * kPlaceBytes) = cost; }

 private:
  static constexpr int kThreads = static_cast<int>(kTileBlockThreads);
  static constexpr int kRedGreenAt = kThreads * 16, kBlueAt = kRedGreenAt + kThreads * 8, kCostBehindBlue = kThreads * 4, kPlaceBytes = kThreads * 32;

  char* where_;
  char* redGreen_;
  char* blue_;  // the cost behind it
};
static_assert(SharedMergerMemory<>::bytesFor(kMostMergerRoom) <= 64 * 1024);

/// Kernels of which most is marched are compiled for the room that the usual number of segments takes: the march is 4 to 11 % faster then.
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
