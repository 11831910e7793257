// Much memory of the host's into the device's, whatever pages it is in: through page-locked memory by several threads, each of which fills a buffer while another is on its way.
// As fast as the bus; what CUDA does itself with pages that are not locked is one thread's (CUDA C++ Best Practices Guide, "Pinned Memory").
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "render/cuda/memory.h"

namespace warpscope::cuda {

struct CopiedRange {
  const std::byte* from = nullptr;  ///< the host's
  std::byte* to = nullptr;          ///< the device's
  size_t bytes = 0;
};

/// For one thread at a time.
class StagedCopy {
 public:
  StagedCopy();
  ~StagedCopy();

  /// Copies all of them, and waits until they are there. `onChunk` is called now and then, on any thread. Throws DeviceError, and what `onChunk` throws.
  void copy(std::span<const CopiedRange> ranges, const std::function<void()>& onChunk);

 private:
  class Lane;
  std::vector<std::unique_ptr<Lane>> lanes_;
};

}  // namespace warpscope::cuda
