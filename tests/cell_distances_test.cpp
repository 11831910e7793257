// Distances over grids of marks against all pairs, in rows longer than any distance and in grids thinner than a vector.
// Mirrors render/volume/cell_distances.h.
#include "render/volume/cell_distances.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <random>
#include <string>

namespace warpscope {
namespace {

using Marks = std::vector<glm::ivec3>;

std::vector<uint8_t> distancesOf(const glm::ivec3& dims, const Marks& marks, bool planesBackwards = false) {
  CellDistances cells(dims);
  for (const glm::ivec3& mark : marks) cells.row(mark.y, mark.z)[mark.x] = CellDistances::kMarked;
  for (int i = 0; i < dims.z; ++i) cells.spreadInPlane(planesBackwards ? dims.z - 1 - i : i);
  return cells.take();
}

void expectPlain(const glm::ivec3& dims, const Marks& marks, const std::string& label) {
  const std::vector<uint8_t> distances = distancesOf(dims, marks);
  ASSERT_EQ(distances.size(), size_t(dims.x) * dims.y * dims.z) << label;
  size_t i = 0;
  for (int z = 0; z < dims.z; ++z)
    for (int y = 0; y < dims.y; ++y)
      for (int x = 0; x < dims.x; ++x, ++i) {
        int nearest = 255;
        for (const glm::ivec3& mark : marks) {
          const glm::ivec3 apart = glm::abs(mark - glm::ivec3(x, y, z));
          nearest = std::min(nearest, std::max(apart.x, std::max(apart.y, apart.z)));
        }
        ASSERT_EQ(int{distances[i]}, nearest) << label << " at " << x << " " << y << " " << z;
      }
  ASSERT_EQ(distances, distancesOf(dims, marks, true)) << label;
}

RC_GTEST_PROP(CellDistances, AreThoseOfAllPairs, (uint32_t seed)) {
  std::mt19937 random(seed);
  glm::ivec3 dims(1 + random() % 70, 1 + random() % 20, 1 + random() % 20);
  std::swap(dims.x, dims[random() % 3]);
  Marks marks(random() % 3 == 0 ? random() % 200 : random() % 4);
  for (glm::ivec3& mark : marks) mark = glm::ivec3(random() % dims.x, random() % dims.y, random() % dims.z);
  expectPlain(dims, marks, "seed " + std::to_string(seed));
  RC_ASSERT(!testing::Test::HasFailure());
}

TEST(CellDistances, SaturateAlongEveryAxis) {
  for (int axis = 0; axis < 3; ++axis)
    for (const int place : {0, 1, 299, 599}) {
      glm::ivec3 dims(1, 2, 1), mark(0);
      dims[axis] = 600;
      mark[axis] = place;
      expectPlain(dims, {mark}, "axis " + std::to_string(axis) + ", from " + std::to_string(place));
    }
}

TEST(CellDistances, OfNoMarksAndOfNothingElse) {
  const glm::ivec3 dims(33, 5, 4);
  expectPlain(dims, {}, "none");
  Marks all;
  for (int i = 0; i < dims.x * dims.y * dims.z; ++i)
    all.push_back({i % dims.x, i / dims.x % dims.y, i / (dims.x * dims.y)});
  expectPlain(dims, all, "all");
  expectPlain(glm::ivec3(1), {}, "one cell");
  expectPlain(glm::ivec3(1), {glm::ivec3(0)}, "one marked cell");
}

}  // namespace
}  // namespace warpscope
