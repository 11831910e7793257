// How far each cell of a grid is from the nearest that is marked, diagonals too (Chebyshev), up to 255. Host only.
// Two sweeps an axis (Rosenfeld, Pfaltz 1966), exact for this metric, by vectors of cells; rows by doubled shifts.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

namespace warpscope {

/// Marks go in by rows, distances come out. In this order: mark all rows of a plane and spread it, in any order of
/// planes and on any threads; then take().
class CellDistances {
 public:
  static constexpr uint8_t kMarked = 0, kUnmarked = 255;

  /// `dims`: at least one cell along each axis.
  explicit CellDistances(const glm::ivec3& dims);

  /// dims.x places to write marks to. Unmarked at first.
  uint8_t* row(int y, int z) { return cells_.data() + placeOf(y, z); }
  /// Distances within a plane of constant z.
  void spreadInPlane(int z);
  /// Distances in the whole grid, x fastest. Saturated: 255 may be more. What is outside the grid is not marked.
  std::vector<uint8_t> take();

 private:
  size_t placeOf(int y, int z) const { return kMargin + (static_cast<size_t>(z) * dims_.y + y) * stride_; }
  void spreadFromPlane(int from, int to);

  /// Between rows, so that the neighbour before the first cell and the one behind the last vector are unmarked.
  static constexpr size_t kMargin = 8;

  glm::ivec3 dims_;
  size_t width_;   // of a row in whole vectors: what is behind its end is cells as well, unmarked ones
  size_t stride_;  // from row to row
  std::vector<uint8_t> cells_;
};

}  // namespace warpscope
