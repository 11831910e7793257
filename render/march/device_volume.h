// A volume in device memory. For .cu files and what they include.
// 8- and 16-bit voxels stay as they are; wider ones become fractions of the volume's range (UnitVoxel), as interpolation wants them.
#pragma once

#include <memory>

#include "render/cuda/memory.h"
#include "render/volume/volume.h"
#include "render/volume/voxel_access.h"

namespace warpscope {

class DeviceVolume {
 public:
  /// Copies the voxels to the current device. Throws DeviceError.
  explicit DeviceVolume(const Volume& volume);

  VoxelType type() const { return type_; }
  /// Some voxels are not finite.
  bool hasHoles() const { return hasHoles_; }
  template <class Voxel>
  const Voxel* voxelsAs() const {
    return reinterpret_cast<const Voxel*>(bytes_.data());
  }

 private:
  VoxelType type_;
  bool hasHoles_;
  cuda::DeviceBuffer<std::byte> bytes_;
};

/// Calls `f.operator()<Voxel, kHasHoles>()` with what the device keeps of `volume`.
template <class F>
void visitDeviceVoxels(const DeviceVolume& volume, F&& f) {
  switch (volume.type()) {
    case VoxelType::uint8: return f.template operator()<uint8_t, false>();
    case VoxelType::int8: return f.template operator()<int8_t, false>();
    case VoxelType::uint16: return f.template operator()<uint16_t, false>();
    case VoxelType::int16: return f.template operator()<int16_t, false>();
    default: return volume.hasHoles() ? f.template operator()<UnitVoxel, true>() : f.template operator()<UnitVoxel, false>();
  }
}

}  // namespace warpscope
