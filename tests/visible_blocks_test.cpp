// That blocks of pixels hold every sample of a visible cell, wherever the camera stands, and leave out most of what is empty.
// Mirrors render/march/visible_blocks.h; the oracle looks at every sample of every ray. Pictures with and without: stability/empty_space_test.cpp.
#include "render/march/visible_blocks.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "marcher_cases.h"

namespace warpscope {
namespace {

/// Cells of 4^3 voxels, each visible with some probability, and a volume around them that lies anywhere.
struct VisibleCells {
  glm::ivec3 voxels{0};
  glm::vec3 lower{0.0f}, voxelEdges{1.0f};
  std::vector<uint8_t> distances;
  EmptyCells cells;

  VisibleCells(std::mt19937& random, const glm::ivec3& theVoxels, float share, const glm::vec3& theLower, const glm::vec3& edges)
      : voxels(theVoxels), lower(theLower), voxelEdges(edges) {
    cells.edgeBits = 2;
    cells.dims = (voxels + 3) / 4;
    distances.resize(static_cast<size_t>(cells.dims.x) * static_cast<size_t>(cells.dims.y) * static_cast<size_t>(cells.dims.z));
    std::uniform_real_distribution<float> uniform;
    for (uint8_t& distance : distances) distance = uniform(random) < share ? 0 : 1;
    cells.distances = distances.data();
  }
  Box bounds() const { return {lower, lower + glm::vec3(voxels) * voxelEdges}; }
};

struct Found {
  size_t visible = 0;   ///< samples in visible cells
  size_t outside = 0;   ///< of them, those that blocks leave out
  size_t emptyRays = 0; ///< rays that meet nothing visible
  size_t leftOut = 0;   ///< of them, those that blocks say so of
};

Found lookAtAll(const VisibleCells& volume, const Camera& camera, float step) {
  const PixelGrid pixels = makePixelGrid(camera, depthRangeOf(camera, volume.bounds()).nearDepth);
  const std::vector<Box> surface = visibleSurface(volume.cells, volume.voxels);
  const VisibleBlocks blocks(pixels, camera.width, camera.height, surface, volume.lower, volume.voxelEdges);
  Found found;
  for (uint32_t y = 0; y < camera.height; ++y)
    for (uint32_t x = 0; x < camera.width; ++x) {
      const PixelRay pixel = pixels.ray(x, y);
      const RayInterval inside =
          intersectBox(reciprocalOf(pixel.ray.origin, pixel.ray.direction), volume.bounds(), 0.0f, std::numeric_limits<float>::infinity());
      const RayLattice lattice = makeLattice(inside, step);
      const glm::vec3 perUnit = 1.0f / volume.voxelEdges;
      const EmptySpace way(volume.cells, (pixel.ray.origin - volume.lower) * perUnit - 0.5f, pixel.ray.direction * perUnit, lattice);
      const VisibleDepths depths = blocks.at(x, y);
      const SampleSpan span = depths.isEmpty() ? SampleSpan{} : samplesBetween(depths, pixel.cosine, lattice);
      const size_t before = found.visible;
      for (int i = 0; i < lattice.count; ++i) {
        if (way.skip(i, lattice) != i) continue;
        ++found.visible;
        found.outside += i < span.begin || i >= span.end;
      }
      if (found.visible != before) continue;
      ++found.emptyRays;
      found.leftOut += span.begin >= span.end;
    }
  return found;
}

TEST(VisibleBlocks, HoldEverySampleOfAVisibleCell) {
  std::mt19937 random(15);
  std::uniform_real_distribution<float> uniform(-1.0f, 1.0f);
  size_t visible = 0;
  for (int round = 0; round < 60; ++round) {
    SCOPED_TRACE(round);
    const float shares[] = {0.002f, 0.02f, 0.3f, 0.97f};
    const float unit = std::pow(10.0f, 3.0f * uniform(random));  // edges of voxels
    const glm::vec3 edges = unit * (1.0f + 0.5f * glm::vec3(uniform(random), uniform(random), uniform(random)));
    const glm::vec3 lower = (round % 3 == 0 ? 1000.0f : 30.0f) * unit * glm::vec3(uniform(random), uniform(random), uniform(random));
    const glm::ivec3 voxels(glm::vec3(33.0f) + 30.0f * glm::vec3(uniform(random), uniform(random), uniform(random)));
    const VisibleCells volume(random, voxels, shares[round % 4], lower, edges);
    // From within the volume to far away; fields of view such that it fills the picture.
    const float size = glm::length(volume.bounds().extent());
    const float away = size * std::pow(10.0f, 0.5f + (round % 5 == 0 ? 4.0f : 1.0f) * uniform(random));
    const glm::vec3 towards = glm::normalize(glm::vec3(uniform(random), uniform(random), uniform(random)) + glm::vec3(0.01f));
    const glm::vec3 target = volume.bounds().center() + 0.2f * size * glm::vec3(uniform(random), uniform(random), uniform(random));
    Camera camera = lookingFrom(target + away * towards, target, 61, 47);
    camera.tanHalfFovY = std::min(0.6f * size / away, 1.0f);
    const Found found = lookAtAll(volume, camera, 0.5f * unit);
    EXPECT_EQ(found.outside, 0u) << "of " << found.visible << " from " << away / size << " sizes away";
    visible += found.visible;
  }
  EXPECT_GT(visible, 100000u);
}

TEST(VisibleBlocks, LeaveOutMostOfWhatIsEmpty) {
  std::mt19937 random(16);
  VisibleCells volume(random, {64, 64, 64}, 0.0f, glm::vec3(-32.0f), glm::vec3(1.0f));
  for (int z = 6; z < 10; ++z)
    for (int y = 6; y < 10; ++y)
      for (int x = 6; x < 10; ++x) volume.distances[static_cast<size_t>((z * volume.cells.dims.y + y) * volume.cells.dims.x + x)] = 0;
  Camera camera = lookingFrom({60.0f, 80.0f, 150.0f}, {}, 256, 256);
  const Found found = lookAtAll(volume, camera, 0.5f);
  EXPECT_EQ(found.outside, 0u);
  EXPECT_GT(found.visible, 1000u);
  EXPECT_GT(static_cast<double>(found.leftOut), 0.9 * static_cast<double>(found.emptyRays));
}

TEST(VisibleBlocks, SurfacesHaveNoInnerCellsAndNotTooManyBoxes) {
  std::mt19937 random(17);
  const VisibleCells solid(random, {64, 64, 64}, 2.0f, glm::vec3(0.0f), glm::vec3(1.0f));
  EXPECT_EQ(visibleSurface(solid.cells, solid.voxels).size(), 16u * 16 * 16 - 14 * 14 * 14);
  VisibleCells inside(random, {64, 64, 64}, 0.0f, glm::vec3(0.0f), glm::vec3(1.0f));
  for (int i = 0; i < 16 * 16 * 16; ++i) {
    const glm::ivec3 cell(i % 16, i / 16 % 16, i / 256);
    if (glm::all(glm::greaterThanEqual(cell, glm::ivec3(4))) && glm::all(glm::lessThan(cell, glm::ivec3(12)))) inside.distances[static_cast<size_t>(i)] = 0;
  }
  EXPECT_EQ(visibleSurface(inside.cells, inside.voxels).size(), 8u * 8 * 8 - 6 * 6 * 6);
  const VisibleCells noise(random, {400, 400, 400}, 0.5f, glm::vec3(0.0f), glm::vec3(1.0f));
  const std::vector<Box> boxes = visibleSurface(noise.cells, noise.voxels);
  EXPECT_LE(boxes.size(), size_t{1} << 15);
  Box all;
  for (const Box& box : boxes) all.include(box);
  EXPECT_EQ(all, (Box{glm::vec3(-0.5f), glm::vec3(399.5f)}));
}

}  // namespace
}  // namespace warpscope
