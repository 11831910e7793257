// A volume cut into bricks, one a rank: a k-d tree (Bentley 1975) whose planes divide what there is to see evenly, and the order in which an eye sees its leaves.
// For rendering in parallel: Ma, Painter, Hansen, Krogh 1994. Cut by what a transfer function shows: Moloney, Weiskopf, Moeller, Strengert 2007, who balance by cost.
#pragma once

#include <span>
#include <vector>

#include "render/march/cell_block.h"
#include "render/volume/macrocells.h"

namespace warpscope {

/// What macrocells weigh before anything is known but what is visible: `distances` are Macrocells::emptyDistances(), 0 where something is to be seen. Others, which a ray
/// leaps over, weigh hardly anything.
std::vector<float> weightsOfVisible(std::span<const uint8_t> distances);

/// Makes weights those that would have told what blocks cost: each is scaled by its block's cost for its weight, at most by kMostScaled. What is hidden behind
/// something else, and where rays end, is known by that alone. `costs`: by block, in any unit; not all 0.
void weighByCost(std::vector<float>& weights, const Macrocells& cells, std::span<const CellBlock> blocks, std::span<const double> costs);
inline constexpr double kMostScaled = 16.0;

/// Throws UsageError, which says how many would do, if a volume of so many voxels cannot be cut into as many blocks.
void requireRoom(const Macrocells& cells, const glm::uvec3& voxels, int count);

class BrickTree {
 public:
  /// Cuts the cells between the voxels of a volume into `count` blocks, none of them empty, along borders of macrocells, so that blocks weigh alike. `weights`: of each macrocell, positive.
  /// Planes are across y or z, along whichever a block is longer, or across x where that is by far the longest (with a `mostShare`
  /// below 1, only where nothing else is left). `mostShare`: of all cells, that a block has at most, whatever it
  /// weighs, as nearly as macrocells let it; less than 1 / count is taken for that.
  /// Throws as requireRoom() does.
  BrickTree(const Macrocells& cells, std::span<const float> weights, const glm::uvec3& voxels, int count, double mostShare = 1.0);

  const std::vector<CellBlock>& blocks() const { return blocks_; }
  /// Every block once: no ray from `eye`, which is in voxel coordinates, comes to one after another that it has come to behind it.
  std::vector<int> nearToFar(const glm::vec3& eye) const;

 private:
  struct Node {
    int axis = 0, place = 0;    ///< cells from `place` on are the upper child's
    int lower = -1, upper = -1;  ///< children; of a leaf `lower` is < 0, `upper` its block
  };

  std::vector<Node> nodes_;  // the root last
  std::vector<CellBlock> blocks_;
};

/// Where places of the block's cells are, in voxel coordinates, all that lies beyond the outermost voxels' centres included.
Box boxOf(const CellBlock& block, const glm::uvec3& voxels);

}  // namespace warpscope
