// Coarse knowledge of a volume for skipping what a transfer function hides.
// Cells of 4^3 voxels (8^3 in large volumes) keep their value range; for a transfer function, each keeps how far away the nearest visible cell is (Chebyshev
// distance, as in Deakin, Knoll 2019, "Efficient ray casting of volumetric images using distance maps").
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "render/core/transfer_table.h"
#include "render/volume/value_scale.h"
#include "render/volume/volume.h"

namespace warpscope {

/// Value range of every cell, as interpolants (value_scale.h). Cell c holds whatever is interpolated at voxel coordinates from
/// edge * c up to and including edge * (c + 1). Copies share what they hold, which never changes.
class Macrocells {
 public:
  /// Reads every voxel once or a little more, in parallel; where ranks share the volume, each its share (Volume). Non-finite voxels are left out.
  Macrocells(const Volume& volume, const ValueScale& scale);

  /// The same cells by another scale; reads no voxels. Shares the ranges where they are the same, see sharesRangesWith().
  Macrocells scaledBy(const ValueScale& scale) const;
  bool sharesRangesWith(const Macrocells& other) const { return ranges_ == other.ranges_; }

  const glm::ivec3& dims() const { return dims_; }
  int edge() const { return edge_; }  ///< voxels along a cell's edge
  size_t count() const { return static_cast<size_t>(dims_.x) * dims_.y * dims_.z; }
  /// x: lowest, y: highest interpolant; x > y where a cell has no finite voxel.
  glm::vec2 range(size_t cell) const { return {ranges_->lowest[cell], ranges_->highest[cell]}; }
  /// count() lowest and highest interpolants of the cells, x fastest, as range() has them.
  const float* lowest() const { return ranges_->lowest.data(); }
  const float* highest() const { return ranges_->highest.data(); }

  /// `table` is of the same interpolants. Per cell: 0 where it shows something in it; else d >= 1: no cell closer than d (in any direction, diagonals too) shows
  /// anything. Saturates at 255. What lies outside the volume shows nothing.
  std::vector<uint8_t> emptyDistances(const TransferTable& table) const;

 private:
  /// Longer than there are cells, by such as have no finite voxel: vectors may read beyond the last one.
  template <class Number>
  struct Ranges {
    std::vector<Number> lowest, highest;
  };
  void findRanges();
  /// Of all cells, where this rank has found what [firstRow, endRow) of their rows have.
  template <class Number>
  void gatherRows(std::vector<Number>& numbers, size_t firstRow, size_t endRow, Ranks& ranks) const;

  VoxelType type_;
  ValueScale scale_;
  int edge_ = 4;
  glm::ivec3 dims_{0};
  std::shared_ptr<const Ranges<double>> ofVoxels_;  // of types whose interpolants depend on the scale; else null
  std::shared_ptr<const Ranges<float>> ranges_;
};

}  // namespace warpscope
