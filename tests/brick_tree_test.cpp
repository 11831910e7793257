// Volumes cut into bricks, one a rank: all of them, by weight, in the order in which rays come to them.
// Mirrors render/bricks/brick_tree.h.
#include "render/bricks/brick_tree.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <random>

#include "marcher_cases.h"
#include "render/march/march_setup.h"
#include "test_volumes.h"

namespace warpscope {
namespace {

bool hasCells(const CellBlock& block) { return glm::all(glm::lessThan(block.lower, block.upper)); }

TEST(BrickTree, BlocksAreTheVolumeAndWeighAlike) {
  const glm::uvec3 dims(130, 65, 90);
  const VolumePtr volume = makeTestVolume(VoxelType::uint8, dims, blobs(dims, 8));
  const MarchedVolume marched(volume, band(30, 90, 0.2f));
  const std::vector<float> weights = weightsOfVisible(marched.bakedFor({})->emptyDistances);
  const glm::ivec3 cells = marched.macrocells.dims();
  for (const int count : {1, 2, 3, 7, 16, 61}) {
    const BrickTree tree(marched.macrocells, weights, dims, count);
    ASSERT_EQ(tree.blocks().size(), static_cast<size_t>(count));
    size_t covered = 0;
    double heaviest = 0.0, all = 0.0;
    for (const CellBlock& block : tree.blocks()) {
      EXPECT_TRUE(hasCells(block));
      covered += static_cast<size_t>(block.upper.x - block.lower.x) * static_cast<size_t>(block.upper.y - block.lower.y) * static_cast<size_t>(block.upper.z - block.lower.z);
      double weight = 0.0;
      for (int z = block.lower.z; z < block.upper.z; z += 4)
        for (int y = block.lower.y; y < block.upper.y; y += 4)
          for (int x = block.lower.x; x < block.upper.x; x += 4)
            weight += static_cast<double>(weights[static_cast<size_t>(((z / 4) * cells.y + y / 4) * cells.x + x / 4)]);
      heaviest = std::max(heaviest, weight);
      all += weight;
    }
    EXPECT_EQ(covered, size_t{129} * 64 * 89);
    EXPECT_LT(heaviest, 1.7 * all / count + 64.0 * 64.0) << count;
  }
}

TEST(BrickTree, NoBlockHasMoreThanThereIsRoomFor) {
  const glm::uvec3 dims(130, 165, 190);
  const VolumePtr volume = makeTestVolume(VoxelType::uint8, dims, blobs(dims, 8));
  const MarchedVolume marched(volume, everywhere(0.1f));
  // Nearly all of the weight is in a corner: without a limit others have nearly all of the cells.
  const glm::ivec3 cells = marched.macrocells.dims();
  std::vector<float> weights(marched.macrocells.count());
  for (size_t i = 0; i < weights.size(); ++i)
    weights[i] = i % static_cast<size_t>(cells.x) < 3 && i / static_cast<size_t>(cells.x) % static_cast<size_t>(cells.y) < 3 && i / static_cast<size_t>(cells.x * cells.y) < 3 ? 1e6f : 1.0f;
  const double all = 129.0 * 164.0 * 189.0;
  const auto largestOf = [&](const BrickTree& tree) {
    double largest = 0.0, covered = 0.0;
    for (const CellBlock& block : tree.blocks()) {
      const glm::dvec3 extent = block.upper - block.lower;
      largest = std::max(largest, extent.x * extent.y * extent.z);
      covered += extent.x * extent.y * extent.z;
    }
    EXPECT_EQ(covered, all);
    return largest;
  };
  for (const int count : {2, 3, 4, 7, 16})
    for (const double most : {0.0, 1.1 / count, 1.5 / count, 3.0 / count})
      EXPECT_LT(largestOf(BrickTree(marched.macrocells, weights, dims, count, most)), std::max(most, 1.0 / count) * 1.25 * all)
          << count << ", " << most << ": macrocells are what there is to cut";
  EXPECT_GT(largestOf(BrickTree(marched.macrocells, weights, dims, 4)), 0.7 * all) << "or the limit would not matter";
}

TEST(BrickTree, EveryBlockOfSmallVolumesHasCellsWhateverTheirNumber) {
  std::mt19937 random(3);
  for (uint32_t x = 2; x <= 17; x += 5)
    for (uint32_t y = 2; y <= 17; y += 5)
      for (uint32_t z = 2; z <= 17; z += 5) {
        const VolumePtr volume = makeTestVolume(VoxelType::uint8, glm::uvec3(x, y, z), [](const glm::ivec3& p) { return 20.0 + p.x; });
        const MarchedVolume marched(volume, everywhere(0.1f));
        const glm::ivec3 room = (glm::ivec3(volume->dims()) - 1 + marched.macrocells.edge() - 1) / marched.macrocells.edge();
        const int most = room.x * room.y * room.z;
        std::vector<float> weights(marched.macrocells.count());
        for (float& weight : weights) weight = static_cast<float>(random() % 1000 + 1);
        for (int count = 1; count <= most; ++count) {
          const BrickTree tree(marched.macrocells, weights, volume->dims(), count);
          ASSERT_EQ(tree.blocks().size(), static_cast<size_t>(count));
          ASSERT_TRUE(std::ranges::all_of(tree.blocks(), hasCells)) << count;
        }
        EXPECT_THROW(BrickTree(marched.macrocells, weights, volume->dims(), most + 1), UsageError);
      }
}

TEST(BrickTree, CutAnewByWhatBlocksCostTheyCostAlike) {
  const glm::uvec3 dims(100, 90, 110);
  const VolumePtr volume = makeTestVolume(VoxelType::uint8, dims, blobs(dims, 8));
  const MarchedVolume marched(volume, everywhere(0.1f));
  // Nearly all there is to do is near one corner, as where rays end in what they come to first.
  const auto costOf = [](const CellBlock& block) {
    double cost = 0.0;
    for (int z = block.lower.z; z < block.upper.z; ++z)
      for (int y = block.lower.y; y < block.upper.y; ++y)
        for (int x = block.lower.x; x < block.upper.x; ++x) cost += std::exp(-0.08 * (x + y + z));
    return cost;
  };
  std::vector<float> weights = weightsOfVisible(marched.bakedFor({})->emptyDistances);
  std::vector<double> unevenness;
  for (int round = 0; round < 8; ++round) {
    const BrickTree tree(marched.macrocells, weights, dims, 8);
    std::vector<double> costs;
    double all = 0.0, most = 0.0;
    for (const CellBlock& block : tree.blocks()) {
      costs.push_back(costOf(block));
      all += costs.back();
      most = std::max(most, costs.back());
    }
    unevenness.push_back(most * 8.0 / all);
    weighByCost(weights, marched.macrocells, tree.blocks(), costs);
  }
  EXPECT_GT(unevenness.front(), 5.0);
  EXPECT_LT(unevenness.back(), 1.6);
}

TEST(BrickTree, RaysComeToBlocksInTheirOrder) {
  const glm::uvec3 dims(64);
  const VolumePtr volume = makeTestVolume(VoxelType::uint8, dims, blobs(dims, 8));
  const MarchedVolume marched(volume, everywhere(0.1f));
  const BrickTree tree(marched.macrocells, weightsOfVisible(marched.bakedFor({})->emptyDistances), dims, 13);
  std::mt19937 random(1);
  std::uniform_real_distribution<float> place(-30.0f, 94.0f);
  std::vector<int> all(tree.blocks().size());
  std::iota(all.begin(), all.end(), 0);
  int met = 0;
  for (int i = 0; i < 2000; ++i) {
    const glm::vec3 eye(place(random), place(random), place(random)), to(place(random), place(random), place(random));
    const std::vector<int> order = tree.nearToFar(eye);
    ASSERT_THAT(order, testing::UnorderedElementsAreArray(all)) << "each block once";
    const glm::vec3 direction = glm::normalize(to - eye);
    float before = -1.0f;
    for (const int at : order) {
      const Box box = boxOf(tree.blocks()[static_cast<size_t>(at)], dims);
      const RayInterval inside = intersectBox(reciprocalOf(eye, direction), box, 0.0f, 1e9f);
      if (inside.isMiss()) continue;
      ASSERT_GE(inside.tNear, before - 1e-3f);
      before = inside.tNear;
      ++met;
    }
  }
  EXPECT_GT(met, 2000);
}

}  // namespace
}  // namespace warpscope
