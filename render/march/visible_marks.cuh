// Which cells show anything, as what distances are spread from. Included by the .cu files that spread them.
#pragma once

#include <cstdint>

#include "render/core/visible_bins.h"
#include "render/cuda/memory.h"

namespace warpscope {

inline constexpr unsigned kCellThreads = 256;
constexpr uint8_t kVisibleCell = 0, kHiddenCell = 255;

/// A cell a thread.
static __global__ void markVisible(const VisibleBins bins, const float* lowest, const float* highest, size_t count, uint8_t* marks) {
  const size_t i = size_t{blockIdx.x} * blockDim.x + threadIdx.x;
  if (i < count) marks[i] = anyVisibleBetween(bins, lowest[i], highest[i]) ? kVisibleCell : kHiddenCell;
}

}  // namespace warpscope
