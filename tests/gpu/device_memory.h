// Devices that have little memory left.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "render/base/error.h"
#include "render/cuda/memory.h"

namespace warpscope {

/// Takes all but `leftBytes` of the device's memory, as long as it is held. In several pieces: what is free need not be had as one.
inline std::vector<cuda::DeviceBuffer<std::byte>> takeMemory(size_t leftBytes) {
  constexpr size_t kLeast = size_t{1} << 20;
  std::vector<cuda::DeviceBuffer<std::byte>> taken;
  for (size_t most = SIZE_MAX; most >= kLeast;) {
    size_t freeBytes = 0, totalBytes = 0;
    WARPSCOPE_CUDA_CHECK(cudaMemGetInfo(&freeBytes, &totalBytes));
    if (freeBytes <= leftBytes) break;
    most = std::min(most, freeBytes - leftBytes);
    try {
      taken.emplace_back(most);
    } catch (const DeviceError&) {
      most /= 2;
    }
  }
  return taken;
}

}  // namespace warpscope
