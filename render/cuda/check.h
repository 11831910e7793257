// Checked CUDA calls and memory that frees itself. For .cu files and the .cpp files beside them; nothing outside render/cuda and tests
// includes it. Every call is checked in Release builds too.
#pragma once

#include <cuda_runtime.h>

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "render/core/error.h"

namespace warpscope::cuda {

inline void check(cudaError_t result, const char* expression, const char* file, int line) {
  if (result == cudaSuccess) return;
  cudaGetLastError();  // reported here; it must not surface in a later call
  throw InputError(std::string("CUDA: ") + cudaGetErrorString(result) + " in " + expression + " (" + file + ":" +
                   std::to_string(line) + ")");
}

/// Throws InputError naming the call and its place if it failed.
#define WARPSCOPE_CUDA_CHECK(expression) ::warpscope::cuda::check((expression), #expression, __FILE__, __LINE__)

/// An array in device memory, of one owner.
template <class T>
class DeviceBuffer {
 public:
  DeviceBuffer() = default;
  explicit DeviceBuffer(size_t count) : count_(count) {
    if (count > 0) WARPSCOPE_CUDA_CHECK(cudaMalloc(&data_, count * sizeof(T)));
  }
  explicit DeviceBuffer(const std::vector<T>& values) : DeviceBuffer(values.size()) {
    if (count_ > 0) WARPSCOPE_CUDA_CHECK(cudaMemcpy(data_, values.data(), count_ * sizeof(T), cudaMemcpyHostToDevice));
  }
  DeviceBuffer(DeviceBuffer&& other) noexcept
      : data_(std::exchange(other.data_, nullptr)), count_(std::exchange(other.count_, 0)) {}
  DeviceBuffer& operator=(DeviceBuffer&& other) noexcept {
    std::swap(data_, other.data_);
    std::swap(count_, other.count_);
    return *this;
  }
  DeviceBuffer(const DeviceBuffer&) = delete;
  DeviceBuffer& operator=(const DeviceBuffer&) = delete;
  ~DeviceBuffer() { cudaFree(data_); }

  T* data() { return data_; }
  size_t size() const { return count_; }
  std::vector<T> toHost() const {
    std::vector<T> values(count_);
    if (count_ > 0) WARPSCOPE_CUDA_CHECK(cudaMemcpy(values.data(), data_, count_ * sizeof(T), cudaMemcpyDeviceToHost));
    return values;
  }

 private:
  T* data_ = nullptr;
  size_t count_ = 0;
};

}  // namespace warpscope::cuda
