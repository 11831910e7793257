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
  const VoxelCell<Voxel>* blends = nullptr;      ///< the cells between voxels, from the first voxel's on; others lie before it, see setCells()
  const VoxelCell<Voxel>* outerBlends = nullptr;  ///< the same, from the one at -1 along each axis on
  glm::ivec3 dims{0};
  AxisEnds ends[3] = {};  ///< of dims
  ValueScale scale;
  glm::vec3 lower{0.0f};          ///< volume-space position of the volume's lower corner
  glm::vec3 voxelsPerUnit{1.0f};  ///< along each axis
  TransferLookup transfer;
  EmptyCells cells;
  OctantCells octants;  ///< where they are known, what samples are looked for by instead

  /// Voxel coordinates of a ray's origin, and voxels per unit of t: as precise as kVoxelPlaceError says.
  WARPSCOPE_HD glm::vec3 voxelOrigin(const Ray& ray) const { return (ray.origin - lower) * voxelsPerUnit - 0.5f; }
  WARPSCOPE_HD glm::vec3 voxelDirection(const Ray& ray) const { return ray.direction * voxelsPerUnit; }
  /// `first`: the cell at -1 along each axis, of voxelCellAt(); x fastest, to the last voxel along each axis.
  WARPSCOPE_HD void setCells(const VoxelCell<Voxel>* first) {
    outerBlends = first;
    blends = first != nullptr ? first + (static_cast<size_t>(1) + cellStrideY() + cellStrideZ()) : nullptr;
  }
  /// Cells from one to the next along y and along z: there is one more than voxels along each axis, see voxelCellAt().
  WARPSCOPE_HD uint32_t cellStrideY() const { return static_cast<uint32_t>(dims.x + 1); }
  WARPSCOPE_HD uint32_t cellStrideZ() const { return cellStrideY() * static_cast<uint32_t>(dims.y + 1); }
  /// Among `blends`, of the cell whose lower voxel is `index`. There are never as many cells as 2^32: device_volume.h keeps larger volumes as voxels.
  WARPSCOPE_HD uint32_t cellPlace(const int (&index)[3]) const {
    return static_cast<uint32_t>(index[2]) * cellStrideZ() + static_cast<uint32_t>(index[1]) * cellStrideY() + static_cast<uint32_t>(index[0]);
  }
  /// What is empty for a ray that goes that way.
  WARPSCOPE_HD EmptyCells emptyCellsTowards(const glm::vec3& direction) const { return octants.distances != nullptr ? octants.towards(direction) : cells; }
};

}  // namespace warpscope
