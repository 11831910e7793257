// Bounds, codes, sort.
// See sorted_cloud.h.
#include "render/warp/device/sorted_cloud.h"

#include <cub/device/device_radix_sort.cuh>

#include "render/cuda/warp_reduce.cuh"

namespace warpscope {
namespace {

constexpr unsigned kSortThreads = 256;
constexpr unsigned kSamplesPerThread = 8;

/// Floats as integers of the same order.
__device__ uint32_t orderedOf(float value) {
  const uint32_t bits = __float_as_uint(value);
  return bits & 0x80000000u ? ~bits : bits | 0x80000000u;
}
__device__ float floatOf(uint32_t ordered) {
  return __uint_as_float(ordered & 0x80000000u ? ordered & 0x7fffffffu : ~ordered);
}

__global__ void boundCenters(DeviceFrameView frame, uint32_t* bounds) {
  Box box;
  const uint32_t first = blockIdx.x * kSortThreads * kSamplesPerThread + threadIdx.x;
  for (unsigned k = 0; k < kSamplesPerThread; ++k) {
    const uint32_t i = first + k * kSortThreads;
    if (i < frame.count) box.include(unpackSample(frame.samples[i], frame.grid).center);
  }
  __shared__ uint32_t shared[6];
  if (threadIdx.x < 6) shared[threadIdx.x] = threadIdx.x < 3 ? 0xffffffffu : 0u;
  __syncthreads();
  box = boxOfWarp(box);
  if (threadIdx.x % 32 == 0)
    for (int axis = 0; axis < 3; ++axis) {
      atomicMin(&shared[axis], orderedOf(box.lower[axis]));
      atomicMax(&shared[3 + axis], orderedOf(box.upper[axis]));
    }
  __syncthreads();
  if (threadIdx.x < 3) atomicMin(&bounds[threadIdx.x], shared[threadIdx.x]);
  if (threadIdx.x >= 3 && threadIdx.x < 6) atomicMax(&bounds[threadIdx.x], shared[threadIdx.x]);
}

__global__ void makeCodes(DeviceFrameView frame, const uint32_t* bounds, uint64_t* codes, uint32_t* ids) {
  const uint32_t i = blockIdx.x * kSortThreads + threadIdx.x;
  if (i >= frame.count) return;
  const Box centers{{floatOf(bounds[0]), floatOf(bounds[1]), floatOf(bounds[2])},
                    {floatOf(bounds[3]), floatOf(bounds[4]), floatOf(bounds[5])}};
  codes[i] = mortonCodeOf(unpackSample(frame.samples[i], frame.grid).center, centers);
  ids[i] = i;
}

}  // namespace

void SortedCloud::build(const DeviceFrameView& frame, int codeBits, cudaStream_t stream) {
  count_ = frame.count;
  reach_ = frame.reach();
  if (count_ == 0) return;
  codes_.reserve(count_);
  unsortedCodes_.reserve(count_);
  ids_.reserve(count_);
  unsortedIds_.reserve(count_);
  WARPSCOPE_CUDA_CHECK(cudaMemsetAsync(bounds_.data(), 0xff, 3 * sizeof(uint32_t), stream));
  WARPSCOPE_CUDA_CHECK(cudaMemsetAsync(bounds_.data() + 3, 0, 3 * sizeof(uint32_t), stream));
  boundCenters<<<cuda::blocksFor(count_, kSortThreads * kSamplesPerThread), kSortThreads, 0, stream>>>(frame, bounds_.data());
  WARPSCOPE_CUDA_CHECK_LAUNCH();
  makeCodes<<<cuda::blocksFor(count_, kSortThreads), kSortThreads, 0, stream>>>(frame, bounds_.data(), unsortedCodes_.data(), unsortedIds_.data());
  WARPSCOPE_CUDA_CHECK_LAUNCH();
  cuda::withScratch(scratch_, [&](void* memory, size_t& bytes) {
    return cub::DeviceRadixSort::SortPairs(memory, bytes, unsortedCodes_.data(), codes_.data(), unsortedIds_.data(), ids_.data(),
                                           static_cast<int>(count_), 63 - codeBits, 63, stream);
  });
}

}  // namespace warpscope
