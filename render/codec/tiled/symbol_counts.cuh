// How often symbols occur, counted by a block in shared memory.
// For .cu files.
#pragma once

#include <cstdint>

#include "render/codec/tiled/ans.h"
#include "render/cuda/warp_reduce.cuh"

namespace warpscope {

/// All threads of a warp call, each with a symbol, or kAnsSymbols for none. `counts`: kAnsSymbols of them.
__device__ inline void countSymbol(uint32_t* counts, uint32_t symbol) {
  const uint32_t zeros = __ballot_sync(kAllLanes, symbol == 0);  // by far the most: one addition for all of a warp
  if (threadIdx.x % 32 == 0 && zeros != 0) atomicAdd(&counts[0], static_cast<uint32_t>(__popc(zeros)));
  if (symbol - 1 < kAnsSymbols - 1) atomicAdd(&counts[symbol], 1u);
}

}  // namespace warpscope
