// Cells' value ranges in device memory, and which of them a function leaves empty. For .cu files and what they include.
// Mirrors Macrocells::emptyDistances: the same bytes.
#pragma once

#include "render/core/visible_bins.h"
#include "render/cuda/memory.h"
#include "render/volume/macrocells.h"

namespace warpscope {

class DeviceCells {
 public:
  /// Copies the ranges to the current device. Throws DeviceError.
  explicit DeviceCells(const Macrocells& cells);

  /// Macrocells::emptyDistances to the front of `distances`, when the stream has got there. `bins` are of the device's
  /// memory; `scratch` is overwritten.
  void findDistances(const VisibleBins& bins, cuda::DeviceBuffer<uint8_t>& distances,
                     cuda::DeviceBuffer<uint8_t>& scratch, cudaStream_t stream) const;

  /// In device memory, as Macrocells has them.
  const float* lowest() const { return lowest_.data(); }
  const float* highest() const { return highest_.data(); }

  size_t count() const { return static_cast<size_t>(dims_.x) * dims_.y * dims_.z; }

 private:
  glm::ivec3 dims_;
  cuda::DeviceBuffer<float> lowest_, highest_;
};

}  // namespace warpscope
