// A range of addresses of the current CUDA device of which parts alone have memory behind them: what is indexed as a whole need not be there as a whole.
// CUDA Driver API, virtual memory management (CUDA 10.2 and newer), asked for by name: a program need not be linked with the driver. Reading where nothing is ends
// the device's work with an error.
#pragma once

#include <cstddef>
#include <map>
#include <span>
#include <utility>
#include <vector>

#include "render/cuda/check.h"

namespace warpscope::cuda {

class SparseMemory {
 public:
  /// Addresses of `bytes` bytes, none of them backed. Throws DeviceError, also where the device has no virtual memory management.
  explicit SparseMemory(size_t bytes);
  ~SparseMemory();
  SparseMemory(const SparseMemory&) = delete;
  SparseMemory& operator=(const SparseMemory&) = delete;

  /// Bytes [begin, end) can be written and read from now on; those that could be before keep what they hold. Throws DeviceError where there is not so much memory; what
  /// has been backed by then stays.
  void back(size_t begin, size_t end);
  /// Nothing is backed any more. Not while the device works with it.
  void release() noexcept;

  std::byte* data() const { return data_; }
  size_t backedBytes() const { return backedBytes_; }

 private:
  struct Part {
    size_t bytes = 0;
    unsigned long long handle = 0;  ///< CUmemGenericAllocationHandle
  };

  void backUnbacked(size_t begin, size_t end);

  int device_ = 0;
  size_t granularity_ = 0;
  size_t reservedBytes_ = 0;
  std::byte* data_ = nullptr;
  std::map<size_t, Part> parts_;  // by where they begin
  size_t backedBytes_ = 0;
};

}  // namespace warpscope::cuda
