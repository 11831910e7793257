// A volume as devices keep it, for tests on the host.
// Mirrors render/march/device_volume.cu, and device_octants.cu by another way.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "render/march/volume_view.h"

namespace warpscope {

/// A view's voxels in cells, and the view of those instead. The latter points into this.
template <class Voxel>
class ViewInCells {
 public:
  explicit ViewInCells(const VolumeView<Voxel>& byVoxels) : view_(byVoxels) {
    for (int z = -1; z < view_.dims.z; ++z)
      for (int y = -1; y < view_.dims.y; ++y)
        for (int x = -1; x < view_.dims.x; ++x) cells_.push_back(voxelCellAt(view_.voxels, view_.dims, {x, y, z}));
    view_.voxels = nullptr;
    view_.setCells(cells_.data());
  }
  ViewInCells(const ViewInCells&) = delete;
  ViewInCells& operator=(const ViewInCells&) = delete;

  const VolumeView<Voxel>& view() const { return view_; }

 private:
  std::vector<VoxelCell<Voxel>> cells_;
  VolumeView<Voxel> view_;
};

/// What OctantCells of a map of cells holds, of which those at 0 in `distances` are visible: by the largest empty cube that a cell is the corner of.
inline std::vector<uint8_t> octantDistances(const uint8_t* distances, const glm::ivec3& dims) {
  const auto placeOf = [&](const glm::ivec3& c) { return (static_cast<size_t>(c.z) * dims.y + c.y) * dims.x + c.x; };
  const size_t count = static_cast<size_t>(dims.x) * dims.y * dims.z;
  std::vector<uint8_t> all(8 * count);
  for (int octant = 0; octant < 8; ++octant) {
    uint8_t* const map = all.data() + static_cast<size_t>(octant) * count;
    const glm::ivec3 way(octant & 1 ? -1 : 1, octant & 2 ? -1 : 1, octant & 4 ? -1 : 1);
    const auto inOrder = [](int i, int length, int sign) { return sign > 0 ? length - 1 - i : i; };
    for (int k = 0; k < dims.z; ++k)
      for (int j = 0; j < dims.y; ++j)
        for (int i = 0; i < dims.x; ++i) {
          const glm::ivec3 cell(inOrder(i, dims.x, way.x), inOrder(j, dims.y, way.y), inOrder(k, dims.z, way.z));
          int nearest = 254;
          for (int neighbour = 1; neighbour < 8; ++neighbour) {
            const glm::ivec3 at = cell + way * glm::ivec3(neighbour & 1, neighbour >> 1 & 1, neighbour >> 2);
            if (glm::all(glm::greaterThanEqual(at, glm::ivec3(0))) && glm::all(glm::lessThan(at, dims))) nearest = std::min<int>(nearest, map[placeOf(at)]);
          }
          map[placeOf(cell)] = static_cast<uint8_t>(distances[placeOf(cell)] == 0 ? 0 : nearest + 1);
        }
  }
  return all;
}

}  // namespace warpscope
