// Devices that have little memory left.
#pragma once

#include "render/cuda/memory.h"

namespace warpscope {

/// Takes all but `leftBytes` of the device's memory.
inline cuda::DeviceBuffer<std::byte> takeMemory(size_t leftBytes) {
  size_t freeBytes = 0, totalBytes = 0;
  WARPSCOPE_CUDA_CHECK(cudaMemGetInfo(&freeBytes, &totalBytes));
  if (freeBytes <= leftBytes) return {};
  return cuda::DeviceBuffer<std::byte>(freeBytes - leftBytes);
}

}  // namespace warpscope
