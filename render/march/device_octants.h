// What a function leaves empty of a volume that a device keeps, for each of the eight ways that rays may go. For .cu files and what they include.
// All of it is found on the device: the value ranges once, the distances after every change of the function. Distances as OctantCells wants them, after
// Deakin, Knoll 2019, whose maps hold for all ways; one-sided ones are longer.
#pragma once

#include "render/core/visible_bins.h"
#include "render/cuda/memory.h"
#include "render/march/device_volume.h"
#include "render/march/empty_space.h"

namespace warpscope {

class DeviceOctants {
 public:
  /// More cells take longer to find again than rays gain by them.
  static constexpr size_t kMostCells = size_t{1} << 22;

  /// Finds the cells' value ranges. Without any cells where the device has little memory left. Throws DeviceError.
  DeviceOctants(const DeviceVolume& volume, const ValueScale& scale);

  bool isKnown() const { return count() > 0; }
  size_t count() const { return static_cast<size_t>(dims_.x) * static_cast<size_t>(dims_.y) * static_cast<size_t>(dims_.z); }
  const glm::ivec3& dims() const { return dims_; }
  int edge() const { return 1 << edgeBits_; }  ///< of a cell, in voxels: 2, or as many more as the volume is larger

  /// Whether the device has room for what findDistances() writes, which the picture may do without. Throws DeviceError.
  bool hasRoomFor(const cuda::DeviceBuffer<uint8_t>& distances) const;
  /// The eight maps to the front of `distances`, when the stream has got there. `bins` are of the device's memory; `scratch` is overwritten.
  void findDistances(const VisibleBins& bins, cuda::DeviceBuffer<uint8_t>& distances, cuda::DeviceBuffer<uint8_t>& scratch, cudaStream_t stream) const;
  /// By what findDistances() has written.
  OctantCells cells(const cuda::DeviceBuffer<uint8_t>& distances) const { return {distances.data(), dims_, edgeBits_}; }

 private:
  glm::ivec3 dims_{0};
  int edgeBits_ = 1;
  cuda::DeviceBuffer<float> lowest_, highest_;  // as Macrocells', of these cells
};

}  // namespace warpscope
