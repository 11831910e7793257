// Sums over what the threads of a block have, and over arrays that one block goes through: where a launch more costs more than what other blocks would save.
// CUB: BlockScan. For .cu files.
#pragma once

#include <cub/block/block_scan.cuh>

#include <cstdint>

namespace warpscope {

/// Of a block with so many threads, all of which call.
template <int kThreads>
class BlockSums {
 public:
  /// Of values of the threads before the calling one; `total`: of all.
  __device__ uint32_t before(uint32_t value, uint32_t& total) {
    uint32_t sum;
    Scan(storage()).ExclusiveSum(value, sum, total);
    __syncthreads();
    return sum;
  }
  __device__ uint32_t greatest(uint32_t value) {
    uint32_t own, all;
    Scan(storage()).InclusiveScan(value, own, [](uint32_t a, uint32_t b) { return max(a, b); }, all);
    __syncthreads();
    return all;
  }
  /// Writes to each of `sums` what `values` in front of it, which may be the same array, add up to; one more of `sums` than of values.
  __device__ void ofArray(const uint32_t* values, uint32_t* sums, uint32_t count) {
    constexpr uint32_t kOwn = 4;  // of a thread at once
    uint32_t sum = 0, next[kOwn];
    const auto look = [&](uint32_t first) {
#pragma unroll
      for (uint32_t k = 0; k < kOwn; ++k) next[k] = first + k < count ? values[first + k] : 0;
    };
    look(threadIdx.x * kOwn);
    for (uint32_t begin = 0; begin < count; begin += kThreads * kOwn) {
      const uint32_t first = begin + threadIdx.x * kOwn;
      uint32_t own[kOwn], all = 0, total;
#pragma unroll
      for (uint32_t k = 0; k < kOwn; ++k) all += own[k] = next[k];
      look(first + kThreads * kOwn);  // does not wait for what follows
      uint32_t at = sum + before(all, total);
#pragma unroll
      for (uint32_t k = 0; k < kOwn; ++k) {
        if (first + k < count) sums[first + k] = at;
        at += own[k];
      }
      sum += total;
    }
    if (threadIdx.x == 0) sums[count] = sum;
  }

 private:
  using Scan = cub::BlockScan<uint32_t, kThreads>;

  __device__ static typename Scan::TempStorage& storage() {
    __shared__ typename Scan::TempStorage all;
    return all;
  }
};

}  // namespace warpscope
