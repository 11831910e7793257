// A volume in device memory. For .cu files and what they include.
// 8- and 16-bit voxels stay as they are; wider ones become interpolants (value_scale.h). Where
// there is room for eight times the volume and a layer around it, it is kept as cells (VoxelCell): one wide load a sample instead of eight narrow ones.
#pragma once

#include <memory>

#include "render/cuda/memory.h"
#include "render/volume/volume.h"
#include "render/volume/voxel_access.h"

namespace warpscope {

class DeviceVolume {
 public:
  /// Copies the voxels to the current device. Throws DeviceError.
  DeviceVolume(const Volume& volume, const ValueScale& scale);

  /// Cells may take at most this much memory; larger volumes are kept as voxels.
  static constexpr size_t kMostCellBytes = size_t{1} << 31;

  VoxelType type() const { return type_; }
  /// Some voxels are not finite.
  bool hasHoles() const { return hasHoles_; }
  bool isInCells() const { return isInCells_; }
  /// Null if the volume is kept in cells.
  template <class Voxel>
  const Voxel* voxelsAs() const {
    return isInCells_ ? nullptr : reinterpret_cast<const Voxel*>(bytes_.data());
  }
  /// For VolumeView::setCells. Null unless the volume is kept in cells.
  template <class Voxel>
  const VoxelCell<Voxel>* cellsAs() const {
    return isInCells_ ? reinterpret_cast<const VoxelCell<Voxel>*>(bytes_.data()) : nullptr;
  }
  const glm::ivec3& dims() const { return dims_; }  ///< voxels along each axis

 private:
  VoxelType type_;
  glm::ivec3 dims_;
  bool hasHoles_;
  bool isInCells_ = false;
  cuda::DeviceBuffer<std::byte> bytes_;
};

/// Calls `f.operator()<Voxel, kHasHoles, kByCells>()` with what the device keeps of `volume`.
template <class F>
void visitDeviceVoxels(const DeviceVolume& volume, F&& f) {
  const auto visit = [&]<class Voxel, bool kHasHoles>() {
    volume.isInCells() ? f.template operator()<Voxel, kHasHoles, true>() : f.template operator()<Voxel, kHasHoles, false>();
  };
  switch (volume.type()) {
    case VoxelType::uint8: return visit.template operator()<uint8_t, false>();
    case VoxelType::int8: return visit.template operator()<int8_t, false>();
    case VoxelType::uint16: return visit.template operator()<uint16_t, false>();
    case VoxelType::int16: return visit.template operator()<int16_t, false>();
    default: return volume.hasHoles() ? visit.template operator()<InterpolantVoxel, true>() : visit.template operator()<InterpolantVoxel, false>();
  }
}

}  // namespace warpscope
