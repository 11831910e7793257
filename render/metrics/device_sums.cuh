// Sums over all pixels on a device: a partial sum a block, then all of them by one block for each quantity, in an order that does not change.
// Harris 2007, "Optimizing parallel reduction in CUDA": shuffles within warps, then one warp over the warps' sums.
#pragma once

#include "render/cuda/warp_reduce.cuh"

namespace warpscope {

/// Sum over a block of at most 1024 threads, a multiple of 32, all of which must call; thread 0 has it.
__device__ inline double blockSum(double value) {
  __shared__ double warps[32];
  const unsigned thread = threadIdx.y * blockDim.x + threadIdx.x, count = blockDim.x * blockDim.y / 32;
  for (int offset = 16; offset > 0; offset /= 2) value += __shfl_down_sync(kAllLanes, value, offset);
  __syncthreads();  // a sum before this one may still be read
  if (thread % 32 == 0) warps[thread / 32] = value;
  __syncthreads();
  value = thread < count ? warps[thread] : 0.0;
  if (thread < 32)
    for (int offset = 16; offset > 0; offset /= 2) value += __shfl_down_sync(kAllLanes, value, offset);
  return value;
}

constexpr unsigned kSumThreads = 1024;

/// totals[q] = sum of partials[q * stride + i], i < count; one block a quantity q.
static __global__ void sumPartials(const double* partials, unsigned stride, unsigned count, double* totals) {
  double sum = 0.0;
  for (unsigned i = threadIdx.x; i < count; i += kSumThreads) sum += partials[size_t{blockIdx.x} * stride + i];
  sum = blockSum(sum);
  if (threadIdx.x == 0) totals[blockIdx.x] = sum;
}

}  // namespace warpscope
