// A transfer table in device memory. For .cu files.
#pragma once

#include <vector>

#include "render/core/transfer_table.h"
#include "render/cuda/memory.h"

namespace warpscope {

class DeviceTable {
 public:
  /// The table's memory is free again when the stream has got there.
  void upload(const TransferTable& table, cudaStream_t stream) {
    lookup_ = table.lookup();
    lookup_.entries = uploaded(entries_, table.entries, stream);
    lookup_.alphas = uploaded(alphas_, table.alphas, stream);
    lookup_.unitAlphas = uploaded(unitAlphas_, table.unitAlphas, stream);
    lookup_.refinements = uploaded(refinements_, table.refinements, stream);
    lookup_.begins = uploaded(begins_, table.begins, stream);
  }
  /// Into this.
  const TransferLookup& lookup() const { return lookup_; }

 private:
  template <class T>
  static const T* uploaded(cuda::DeviceBuffer<T>& memory, const std::vector<T>& values, cudaStream_t stream) {
    memory.upload(values, stream);
    return memory.data();
  }

  TransferLookup lookup_;
  cuda::DeviceBuffer<glm::vec4> entries_;
  cuda::DeviceBuffer<float> alphas_, unitAlphas_;
  cuda::DeviceBuffer<TransferRefinement> refinements_;
  cuda::DeviceBuffer<float> begins_;
};

}  // namespace warpscope
