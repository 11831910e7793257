// A sum that a device's threads add to (device_hash.cuh), and the host reads. For .cu files and what they include.
#pragma once

#include <cstdint>

#include "render/cuda/memory.h"

namespace warpscope {

class DeviceSum {
 public:
  void clear(cudaStream_t stream) { WARPSCOPE_CUDA_CHECK(cudaMemsetAsync(there_.data(), 0, sizeof(unsigned long long), stream)); }
  /// What is added to.
  unsigned long long* data() { return there_.data(); }
  /// onHost() is the sum when the stream has got there.
  void fetch(cudaStream_t stream) { WARPSCOPE_CUDA_CHECK(cudaMemcpyAsync(here_.data(), there_.data(), sizeof(uint64_t), cudaMemcpyDeviceToHost, stream)); }
  uint64_t onHost() const { return *here_; }

 private:
  cuda::DeviceBuffer<unsigned long long> there_{1};
  cuda::PinnedValue<uint64_t> here_;
};

}  // namespace warpscope
