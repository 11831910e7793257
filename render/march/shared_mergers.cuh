// Segments that rays on a device merge, in shared memory: arrays that are indexed would be in local memory, a word at a time from far away.
// For .cu files.
#pragma once

#include "render/cuda/check.h"
#include "render/cuda/pixel_tiles.cuh"
#include "render/march/ray_segments.h"

namespace warpscope {

/// A thread's part of what a kernel was launched with: word by word beside those of the other threads, so that no two of a warp are in one bank.
class SharedMergerMemory {
 public:
  static constexpr size_t bytesFor(int room) { return size_t{kTileBlockThreads} * static_cast<size_t>(room) * kPlaceWords * sizeof(float); }

  __device__ SharedMergerMemory() {
    extern __shared__ float mergerWords[];
    words_ = mergerWords + threadIdx.x;
  }

  __device__ RaySegment segment(int i) const {
    const float* const at = words_ + i * kPlaceWords * kStride;
    RaySegment segment;
    segment.begin = at[0];
    segment.end = at[kStride];
    segment.opacity = at[2 * kStride];
    segment.through = at[3 * kStride];
    segment.color = {at[4 * kStride], at[5 * kStride], at[6 * kStride]};
    return segment;
  }
  __device__ void setSegment(int i, const RaySegment& segment) {
    float* const at = words_ + i * kPlaceWords * kStride;
    at[0] = segment.begin;
    at[kStride] = segment.end;
    at[2 * kStride] = segment.opacity;
    at[3 * kStride] = segment.through;
    at[4 * kStride] = segment.color.x;
    at[5 * kStride] = segment.color.y;
    at[6 * kStride] = segment.color.z;
  }
  __device__ uint32_t cost(int i) const { return __float_as_uint(words_[(i * kPlaceWords + kCostWord) * kStride]); }
  __device__ void setCost(int i, uint32_t cost) { words_[(i * kPlaceWords + kCostWord) * kStride] = __uint_as_float(cost); }

 private:
  static constexpr int kCostWord = sizeof(RaySegment) / sizeof(float), kPlaceWords = kCostWord + 1;
  static_assert(kCostWord == 7);
  static constexpr int kStride = static_cast<int>(kTileBlockThreads);

  float* words_;
};

using SharedSegmentMerger = BasicSegmentMerger<SharedMergerMemory>;

/// Launches a kernel whose threads have a SharedSegmentMerger each, for rays of which `most` segments are wanted.
template <class... Parameters, class... Arguments>
void launchWithMergers(void (*kernel)(Parameters...), dim3 grid, cudaStream_t stream, int most, const Arguments&... arguments) {
  const size_t bytes = SharedMergerMemory::bytesFor(mergerRoomFor(most));
  WARPSCOPE_CUDA_CHECK(cudaFuncSetAttribute(kernel, cudaFuncAttributeMaxDynamicSharedMemorySize, static_cast<int>(bytes)));
  kernel<<<grid, kTileBlockThreads, bytes, stream>>>(arguments...);
}

}  // namespace warpscope
