// Sums of what words add to a hash at their places (placed_hash.h), by all threads of a device. For .cu files.
#pragma once

#include <cstdint>

#include "render/core/placed_hash.h"
#include "render/cuda/warp_reduce.cuh"

namespace warpscope {
namespace {

/// The sum of all threads' hashes.
__device__ void addHash(uint64_t own, unsigned long long* hash) {
  for (int offset = 16; offset > 0; offset /= 2) own += __shfl_xor_sync(kAllLanes, own, offset);
  if (threadIdx.x % 32 == 0 && own != 0) atomicAdd(hash, static_cast<unsigned long long>(own));
}

}  // namespace
}  // namespace warpscope
