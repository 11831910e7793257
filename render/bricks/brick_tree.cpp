// Cutting where the weight on both sides is as what is to go there.
// See brick_tree.h.
#include "render/bricks/brick_tree.h"

#include <algorithm>
#include <functional>
#include <numeric>
#include <string>

#include "render/base/error.h"

namespace warpscope {
namespace {

/// Macrocells [lower, upper).
struct Cells {
  glm::ivec3 lower, upper;

  glm::ivec3 extent() const { return upper - lower; }
};

/// Cells between voxels.
glm::ivec3 cellsBetween(const glm::uvec3& voxels) { return glm::max(glm::ivec3(voxels) - 1, 1); }

/// Those that have cells: where the last voxel along an axis begins a macrocell, that has none.
Cells withCells(const Macrocells& macrocells, const glm::uvec3& voxels) {
  return {glm::ivec3(0), (cellsBetween(voxels) + macrocells.edge() - 1) / macrocells.edge()};
}

/// Calls `visit(i, at)` with the number and the place of each.
template <class Visit>
void forEachCell(const Cells& cells, const glm::ivec3& dims, const Visit& visit) {
  for (int z = cells.lower.z; z < cells.upper.z; ++z)
    for (int y = cells.lower.y; y < cells.upper.y; ++y)
      for (int x = cells.lower.x; x < cells.upper.x; ++x)
        visit((static_cast<size_t>(z) * static_cast<size_t>(dims.y) + static_cast<size_t>(y)) * static_cast<size_t>(dims.x) + static_cast<size_t>(x), glm::ivec3(x, y, z));
}

/// How many blocks a piece of so many macrocells can become.
int64_t countOf(const Cells& cells) { return int64_t{cells.extent().x} * cells.extent().y * cells.extent().z; }

/// Across x only where it is by far the longest: what lies side by side along x is in the same pages of memory, which both sides would have to read. Where there is little room, whose
/// rows are whole as well, only where nothing else is left to cut.
int axisToCut(const glm::ivec3& extent, bool isRoomShort) {
  constexpr int kByFar = 4;
  const int other = extent.y > extent.z ? 1 : 2;
  return (extent.x > kByFar * extent[other] && !isRoomShort) || extent[other] < 2 ? 0 : other;
}

}  // namespace

std::vector<float> weightsOfVisible(std::span<const uint8_t> distances) {
  constexpr float kVisible = 64.0f, kHidden = 1.0f;
  std::vector<float> weights(distances.size());
  std::ranges::transform(distances, weights.begin(), [](uint8_t distance) { return distance == 0 ? kVisible : kHidden; });
  return weights;
}

void weighByCost(std::vector<float>& weights, const Macrocells& cells, std::span<const CellBlock> blocks, std::span<const double> costs) {
  // A block's last macrocells may be cut short by the volume's end.
  const auto forEachWeight = [&](const CellBlock& block, const auto& visit) {
    forEachCell({block.lower / cells.edge(), (block.upper + cells.edge() - 1) / cells.edge()}, cells.dims(), [&](size_t cell, const glm::ivec3&) { visit(weights[cell]); });
  };
  std::vector<double> ofBlocks(blocks.size());
  double weightOfAll = 0.0, costOfAll = 0.0;
  for (size_t i = 0; i < blocks.size(); ++i) {
    forEachWeight(blocks[i], [&](float weight) { ofBlocks[i] += static_cast<double>(weight); });
    weightOfAll += ofBlocks[i];
    costOfAll += costs[i];
  }
  for (size_t i = 0; i < blocks.size(); ++i) {
    const double scale = std::clamp(costs[i] / costOfAll * (weightOfAll / ofBlocks[i]), 1.0 / kMostScaled, kMostScaled);
    forEachWeight(blocks[i], [&](float& weight) { weight = std::max(static_cast<float>(static_cast<double>(weight) * scale), 1e-12f); });
  }
}

void requireRoom(const Macrocells& cells, const glm::uvec3& voxels, int count) {
  if (const int64_t most = countOf(withCells(cells, voxels)); count > most)
    throw UsageError("the volume is too small for " + std::to_string(count) + " processes: there is work for " + std::to_string(most) + " at most");
}

BrickTree::BrickTree(const Macrocells& macrocells, std::span<const float> weights, const glm::uvec3& voxels, int count, double mostShare) {
  const glm::ivec3 dims = macrocells.dims();
  requireRoom(macrocells, voxels, count);
  const Cells all = withCells(macrocells, voxels);
  const glm::ivec3 cells = cellsBetween(voxels);
  /// The macrocells' voxels; the volume's ends where they are.
  const auto blockOf = [&](const Cells& piece) { return CellBlock{piece.lower * macrocells.edge(), glm::min(piece.upper * macrocells.edge(), cells)}; };
  const double mostCells = std::max(mostShare, 1.0 / count) * static_cast<double>(countOf(all));
  /// As many of the piece's slices as so many blocks may have, or the nearest number that leaves the others no more than they may.
  const auto withinRoom = [&](const Cells& piece, int axis, int slices, int ofLower, int ofUpper) {
    const double perSlice = static_cast<double>(countOf(piece)) / piece.extent()[axis];
    const auto slicesOf = [&](int blocks) { return static_cast<int>(std::min(mostCells * blocks / perSlice, 1e9)); };
    const int least = std::max(1, piece.extent()[axis] - slicesOf(ofUpper)), most = std::min(piece.extent()[axis] - 1, slicesOf(ofLower));
    return least <= most ? std::clamp(slices, least, most) : std::clamp((least + most) / 2, 1, piece.extent()[axis] - 1);
  };
  const auto weightOfSlices = [&](const Cells& piece, int axis) {
    std::vector<double> ofSlices(static_cast<size_t>(piece.extent()[axis]));
    forEachCell(piece, dims, [&](size_t cell, const glm::ivec3& at) { ofSlices[static_cast<size_t>(at[axis] - piece.lower[axis])] += static_cast<double>(weights[cell]); });
    return ofSlices;
  };
  const std::function<int(const Cells&, int)> cut = [&](const Cells& piece, int blocks) -> int {
    if (blocks == 1) {
      blocks_.push_back(blockOf(piece));
      nodes_.push_back({0, 0, -1, static_cast<int>(blocks_.size()) - 1});
      return static_cast<int>(nodes_.size()) - 1;
    }
    const int axis = axisToCut(piece.extent(), mostShare < 1.0);
    const std::vector<double> ofSlices = weightOfSlices(piece, axis);
    const double wanted = std::accumulate(ofSlices.begin(), ofSlices.end(), 0.0) * (blocks / 2) / blocks;
    int slices = 1;
    for (double below = ofSlices[0]; slices + 1 < piece.extent()[axis]; ++slices) {
      const double next = ofSlices[static_cast<size_t>(slices)];
      if (below + 0.5 * next >= wanted) break;
      below += next;
    }
    slices = withinRoom(piece, axis, slices, blocks / 2, blocks - blocks / 2);
    Cells lower = piece, upper = piece;
    lower.upper[axis] = upper.lower[axis] = piece.lower[axis] + slices;
    // Half of the blocks, or as many more or fewer as both sides have room for.
    const int64_t least = std::max<int64_t>(1, blocks - countOf(upper)), most = std::min<int64_t>(blocks - 1, countOf(lower));
    const int ofLower = static_cast<int>(std::clamp<int64_t>(blocks / 2, least, most));
    const int place = upper.lower[axis] * macrocells.edge();
    const int first = cut(lower, ofLower), second = cut(upper, blocks - ofLower);
    nodes_.push_back({axis, place, first, second});
    return static_cast<int>(nodes_.size()) - 1;
  };
  cut(all, count);
}

std::vector<int> BrickTree::nearToFar(const glm::vec3& eye) const {
  std::vector<int> order;
  const std::function<void(int)> visit = [&](int at) {
    const Node& node = nodes_[static_cast<size_t>(at)];
    if (node.lower < 0) return order.push_back(node.upper);
    const bool isBelow = eye[node.axis] < static_cast<float>(node.place);
    visit(isBelow ? node.lower : node.upper);
    visit(isBelow ? node.upper : node.lower);
  };
  visit(static_cast<int>(nodes_.size()) - 1);
  return order;
}

Box boxOf(const CellBlock& block, const glm::uvec3& voxels) {
  Box box;
  for (int axis = 0; axis < 3; ++axis) {
    const int cells = std::max(static_cast<int>(voxels[axis]) - 1, 1);
    box.lower[axis] = block.lower[axis] > 0 ? static_cast<float>(block.lower[axis]) : -0.5f;
    box.upper[axis] = block.upper[axis] < cells ? static_cast<float>(block.upper[axis]) : static_cast<float>(voxels[axis]) - 0.5f;
  }
  return box;
}

}  // namespace warpscope
