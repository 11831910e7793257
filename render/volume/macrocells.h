// Coarse knowledge of a volume for skipping what a transfer function hides.
// Cells of 4^3 voxels (8^3 in large volumes) keep their value range; for a transfer function, each keeps how far away the nearest visible cell is (Chebyshev
// distance, as in Deakin, Knoll 2019, "Efficient ray casting of volumetric images using distance maps").
#pragma once

#include <cstdint>
#include <vector>

#include "render/core/transfer_table.h"
#include "render/volume/value_scale.h"
#include "render/volume/volume.h"

namespace warpscope {

/// Value range of every cell, as interpolants (value_scale.h). Cell c holds whatever is interpolated at voxel coordinates from
/// edge * c up to and including edge * (c + 1).
class Macrocells {
 public:
  /// Reads every voxel once or a little more, in parallel. Non-finite voxels are left out.
  Macrocells(const Volume& volume, const ValueScale& scale);

  const glm::ivec3& dims() const { return dims_; }
  int edge() const { return edge_; }  ///< voxels along a cell's edge
  size_t count() const { return ranges_.size(); }
  /// x: lowest, y: highest interpolant; x > y where a cell has no finite voxel.
  const std::vector<glm::vec2>& ranges() const { return ranges_; }

  /// `table` is of the same interpolants. Per cell: 0 where it shows something in it; else d >= 1: no cell closer than d (in any direction, diagonals too) shows
  /// anything. Saturates at 255. What lies outside the volume shows nothing.
  std::vector<uint8_t> emptyDistances(const TransferTable& table) const;

 private:
  int edge_ = 4;
  glm::ivec3 dims_{0};
  std::vector<glm::vec2> ranges_;
};

}  // namespace warpscope
