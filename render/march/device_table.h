// Transfer tables in device memory. For .cu files.
#pragma once

#include <vector>

#include "render/core/segment_table.h"
#include "render/core/transfer_table.h"
#include "render/cuda/memory.h"

namespace warpscope {

template <class T>
const T* uploaded(cuda::DeviceBuffer<T>& memory, const std::vector<T>& values, cudaStream_t stream) {
  memory.upload(values, stream);
  return memory.data();
}

/// Colours and opacities of a table's entries, whichever kind of table it is.
class DeviceEntries {
 public:
  /// What a lookup into them has. The table's memory is free again when the stream has got there.
  template <class Table>
  auto upload(const Table& table, cudaStream_t stream) {
    auto lookup = table.lookup();
    lookup.entries = uploaded(entries_, table.entries, stream);
    lookup.alphas = uploaded(alphas_, table.alphas, stream);
    lookup.unitAlphas = uploaded(unitAlphas_, table.unitAlphas, stream);
    return lookup;
  }

 private:
  cuda::DeviceBuffer<glm::vec4> entries_;
  cuda::DeviceBuffer<float> alphas_, unitAlphas_;
};

class DeviceTable {
 public:
  /// The table's memory is free again when the stream has got there.
  void upload(const TransferTable& table, cudaStream_t stream) {
    lookup_ = entries_.upload(table, stream);
    lookup_.refinements = uploaded(refinements_, table.refinements, stream);
    lookup_.begins = uploaded(begins_, table.begins, stream);
  }
  /// Into this.
  const TransferLookup& lookup() const { return lookup_; }

 private:
  TransferLookup lookup_;
  DeviceEntries entries_;
  cuda::DeviceBuffer<TransferRefinement> refinements_;
  cuda::DeviceBuffer<float> begins_;
};

/// What steps between two values show (segment_table.h), of functions that are asked for it.
class DeviceSegmentTable {
 public:
  /// The table's memory is free again when the stream has got there.
  void upload(const SegmentTable& table, cudaStream_t stream) { lookup_ = entries_.upload(table, stream); }
  void clear() { lookup_ = {.nodes = 0}; }
  bool isEmpty() const { return lookup_.nodes == 0; }
  /// Into this.
  const SegmentLookup& lookup() const { return lookup_; }

 private:
  SegmentLookup lookup_{.nodes = 0};
  DeviceEntries entries_;
};

}  // namespace warpscope
