// What rays share: a volume, its values' scale, a baked transfer function and what is empty. For host and device; the memory is another's.
// Positions are turned into voxel coordinates as voxel_access.h defines them.
#pragma once

#include <cstdint>

#include "render/core/ray.h"
#include "render/march/empty_space.h"
#include "render/volume/voxel_access.h"

namespace warpscope {

/// What the place of a ray's point, mulAdd(t, voxelDirection, voxelOrigin), is off by along each axis, relative to the
/// terms that it is the sum of: voxels from the volume's corner to the origin, the half, voxels along the ray. Origin
/// less corner, times voxels per unit, less the half, and the sum itself.
inline constexpr double kVoxelPlaceError = 4.001 * 0x1p-24;

template <class Voxel>
struct VolumeView {
  const Voxel* voxels = nullptr;            ///< x fastest, or null if there are
  const VoxelCell<Voxel>* blends = nullptr;  ///< the cells between voxels: one fewer than voxels along each axis, but at least one
  glm::ivec3 dims{0};
  AxisEnds ends[3] = {};  ///< of dims
  ValueScale scale;
  glm::vec3 lower{0.0f};          ///< volume-space position of the volume's lower corner
  glm::vec3 voxelsPerUnit{1.0f};  ///< along each axis
  TransferLookup transfer;
  EmptyCells cells;

  /// Voxel coordinates of a ray's origin, and voxels per unit of t: as precise as kVoxelPlaceError says.
  WARPSCOPE_HD glm::vec3 voxelOrigin(const Ray& ray) const { return (ray.origin - lower) * voxelsPerUnit - 0.5f; }
  WARPSCOPE_HD glm::vec3 voxelDirection(const Ray& ray) const { return ray.direction * voxelsPerUnit; }
  /// Among `blends`, of the cell whose lower voxel is `index`. There are never as many cells as 2^32: device_volume.h keeps larger volumes as voxels.
  WARPSCOPE_HD uint32_t cellPlace(const int (&index)[3]) const {
    const uint32_t row = static_cast<uint32_t>(index[2]) * static_cast<uint32_t>(ends[1].lastCell + 1) + static_cast<uint32_t>(index[1]);
    return row * static_cast<uint32_t>(ends[0].lastCell + 1) + static_cast<uint32_t>(index[0]);
  }
};

}  // namespace warpscope
