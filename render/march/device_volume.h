// A volume in device memory. For .cu files and what they include.
// 8- and 16-bit voxels stay as they are; wider ones become interpolants (value_scale.h). Where
// there is room for eight times the volume and a layer around it, it is kept as cells (VoxelCell): one wide load a sample instead of eight narrow ones.
#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "render/cuda/memory.h"
#include "render/cuda/sparse_memory.h"
#include "render/cuda/staged_copy.h"
#include "render/volume/volume.h"
#include "render/volume/voxel_access.h"

namespace warpscope {

/// Bytes that a device keeps of a voxel.
size_t bytesOnDevice(VoxelType type);

/// Bytes that a volume may take of the current device, beside what it holds already and what marching takes: as there is room, shared by those who share the device
/// (deviceSharers()), or as deviceMemoryLimit() has it.
size_t roomOnDevice();
/// Slices along z, of those that the volume has, that there is such room for.
int slicesOnDevice(const Volume& volume);

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

/// The same of those rows of voxels that are asked for: each voxel is where it would be if all were there, and never in a cell.
class DeviceBrick {
 public:
  /// None yet, on the current device. Throws DeviceError.
  DeviceBrick(VolumePtr volume, const ValueScale& scale);

  /// The volume has these rows (Volume::provide()); so has the device from now on. Others go when there are many of them, or where there is no room for both. Throws
  /// DeviceError, or OperationCancelled if `stop` is set, and has none then. Not while the device reads voxels.
  void provide(const VoxelRows& rows, const std::stop_token& stop = {});

  VoxelType type() const { return volume_->type(); }
  bool hasHoles() const { return volume_->statistics().nonFinite > 0; }
  /// Of the volume's first voxel, whether it is there or not.
  template <class Voxel>
  const Voxel* voxelsAs() const {
    return reinterpret_cast<const Voxel*>(memory_.data());
  }
  size_t bytes() const { return memory_.backedBytes(); }

 private:
  using Rows = std::pair<uint32_t, uint32_t>;  // along y: [first, second)

  /// As provide(), of what is not there.
  void addMissing(const VoxelRows& rows, const std::stop_token& stop);
  void forget();

  const VolumePtr volume_;
  const ValueScale scale_;
  const size_t roomBytes_;
  cuda::SparseMemory memory_;
  cuda::StagedCopy copy_;
  std::vector<Rows> rows_;  // of each slice
  size_t lostRows_ = 0;     // that nobody knows any more, but whose memory is still there
};

/// Calls `f.operator()<Voxel, kHasHoles>()` with what a device keeps of voxels of that type.
template <class F>
void visitKeptVoxels(VoxelType type, bool hasHoles, F&& f) {
  switch (type) {
    case VoxelType::uint8: return f.template operator()<uint8_t, false>();
    case VoxelType::int8: return f.template operator()<int8_t, false>();
    case VoxelType::uint16: return f.template operator()<uint16_t, false>();
    case VoxelType::int16: return f.template operator()<int16_t, false>();
    default: return hasHoles ? f.template operator()<InterpolantVoxel, true>() : f.template operator()<InterpolantVoxel, false>();
  }
}
/// Calls `f.operator()<Voxel, kHasHoles, kByCells>()` with what the device keeps of `volume`.
template <class F>
void visitDeviceVoxels(const DeviceVolume& volume, F&& f) {
  visitKeptVoxels(volume.type(), volume.hasHoles(), [&]<class Voxel, bool kHasHoles>() {
    volume.isInCells() ? f.template operator()<Voxel, kHasHoles, true>() : f.template operator()<Voxel, kHasHoles, false>();
  });
}

}  // namespace warpscope
