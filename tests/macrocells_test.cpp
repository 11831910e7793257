// Macrocells against brute force: value ranges over all voxels of a cell, distances over all pairs of cells.
// Mirrors render/volume/macrocells.h.
#include "render/volume/macrocells.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cstdlib>
#include <random>

#include "render/core/visible_bins.h"
#include "render/volume/voxel_access.h"
#include "test_volumes.h"

namespace warpscope {
namespace {

const double kNan = std::nan("");
const double kInfinity = std::numeric_limits<double>::infinity();

ValueScale scaleFor(const Volume& volume, const TransferFunction& function) {
  return valueScaleOf(volume.type(), volume.statistics(), function);
}

TransferTable tableFor(const Volume& volume, const TransferFunction& function) {
  return bakeTransferTable(function, volume, scaleFor(volume, function), 0.5f);
}

Macrocells cellsFor(const Volume& volume, const TransferFunction& function) { return {volume, scaleFor(volume, function)}; }

/// Cells where no transfer function matters.
Macrocells cellsOf(const Volume& volume) { return cellsFor(volume, {}); }

/// Shown from `value` on.
TransferFunction shownFrom(double value) {
  return {{{value, glm::vec3(1.0f), 0.0f}, {value, glm::vec3(1.0f), 0.5f}}};
}

glm::ivec3 cellAt(const Macrocells& cells, size_t i) {
  const glm::ivec3 n = cells.dims();
  return {static_cast<int>(i) % n.x, static_cast<int>(i) / n.x % n.y, static_cast<int>(i) / (n.x * n.y)};
}

void expectRanges(const Volume& volume, const std::string& label) {
  const Macrocells cells = cellsOf(volume);
  const ValueScale scale = scaleFor(volume, {});
  const glm::ivec3 n(volume.dims());
  ASSERT_EQ(cells.dims(), (n + cells.edge() - 1) / cells.edge()) << label;
  ASSERT_EQ(cells.count(), size_t(cells.dims().x) * cells.dims().y * cells.dims().z);
  for (size_t i = 0; i < cells.count(); ++i) {
    const glm::ivec3 first = cellAt(cells, i) * cells.edge();
    double lowest = kInfinity, highest = -kInfinity;
    for (int z = first.z; z <= std::min(first.z + cells.edge(), n.z - 1); ++z)
      for (int y = first.y; y <= std::min(first.y + cells.edge(), n.y - 1); ++y)
        for (int x = first.x; x <= std::min(first.x + cells.edge(), n.x - 1); ++x)
          visitVoxelType(volume.type(), [&](auto tag) {
            const auto v = static_cast<double>(volume.voxelsAs<decltype(tag)>()[(size_t(z) * n.y + y) * n.x + x]);
            if (!std::isfinite(v)) return;
            lowest = std::min(lowest, v);
            highest = std::max(highest, v);
          });
    const glm::vec2 range = cells.range(i);
    if (lowest > highest) {
      ASSERT_GT(range.x, range.y) << label << ", cell " << i;
      continue;
    }
    ASSERT_EQ(range.x, static_cast<float>(scale.interpolantOf(lowest))) << label << ", cell " << i;
    ASSERT_EQ(range.y, static_cast<float>(scale.interpolantOf(highest))) << label << ", cell " << i;
  }
}

TEST(Macrocells, RangesOfEveryTypeAndShape) {
  for (const VoxelType type : kAllVoxelTypes)
    for (const glm::uvec3 dims : {glm::uvec3(1), glm::uvec3(4), glm::uvec3(5), glm::uvec3(17, 9, 13), glm::uvec3(1, 30, 2),
                                  glm::uvec3(70, 1, 1)})
      expectRanges(*makeTestVolume(type, dims, blobs(dims, 5)), std::string(nameOf(type)));
}

TEST(Macrocells, ConstantAndLargeBesideTheirExtent) {
  expectRanges(*makeTestVolume(VoxelType::float64, glm::uvec3(9), [](auto) { return 3.5; }), "constant");
  expectRanges(*makeTestVolume(VoxelType::int32, glm::uvec3(9), [](auto p) { return 2e9 + p.x; }), "large");
  expectRanges(*makeTestVolume(VoxelType::float64, glm::uvec3(9), [](auto p) { return 1e15 + p.y; }), "larger");
}

TEST(Macrocells, NonFiniteVoxelsAreLeftOut) {
  const auto field = [](const glm::ivec3& p) {
    if (p.x > 11) return kNan;  // whole cells
    if ((p.x + p.y + p.z) % 5 == 0) return p.y % 2 ? kInfinity : kNan;
    return static_cast<double>(p.x * p.y - p.z);
  };
  for (const VoxelType type : {VoxelType::float32, VoxelType::float64}) {
    const VolumePtr volume = makeTestVolume(type, {20, 11, 9}, field);
    expectRanges(*volume, "holes");
    const Macrocells cells = cellsOf(*volume);
    const std::vector<uint8_t> distances = cells.emptyDistances(tableFor(*volume, shownFrom(-1e9)));
    for (size_t i = 0; i < cells.count(); ++i) {
      const int x = cellAt(cells, i).x;
      EXPECT_EQ(distances[i], x <= 2 ? 0 : x - 2) << i;  // nothing to see where no voxel is finite
    }
  }
}

/// Whether a cell shows something, by the table's own answer.
bool isVisible(const TransferTable& table, const glm::vec2& range) {
  const float slack = range.x < range.y ? kRangeSlack * std::max(std::abs(range.x), std::abs(range.y)) : 0.0f;
  return range.x <= range.y && table.anyVisible(range.x - slack, range.y + slack);
}

void expectDistances(const Volume& volume, const TransferFunction& function, const std::string& label) {
  const Macrocells cells = cellsFor(volume, function);
  const TransferTable table = tableFor(volume, function);
  const std::vector<uint8_t> distances = cells.emptyDistances(table);
  ASSERT_EQ(distances.size(), cells.count());
  std::vector<glm::ivec3> visible;
  for (size_t i = 0; i < cells.count(); ++i)
    if (distances[i] == 0) visible.push_back(cellAt(cells, i));
  for (size_t i = 0; i < cells.count(); ++i) {
    int nearest = 255;
    for (const glm::ivec3& other : visible) {
      const glm::ivec3 apart = glm::abs(other - cellAt(cells, i));
      nearest = std::min(nearest, std::max(apart.x, std::max(apart.y, apart.z)));
    }
    ASSERT_EQ(int{distances[i]}, nearest) << label << ", cell " << i;
    ASSERT_EQ(distances[i] == 0, isVisible(table, cells.range(i))) << label << ", cell " << i;
    // Every cell that holds something visible says so; the converse may fail within the slack only.
    const glm::vec2 range = cells.range(i);
    if (table.anyVisible(range.x, range.y)) {
      ASSERT_EQ(distances[i], 0) << label << ", cell " << i;
    }
    const float slack = 1e-3f * (1.0f + std::abs(range.x) + std::abs(range.y));
    if (!table.anyVisible(range.x - slack, range.y + slack)) {
      ASSERT_GT(distances[i], 0) << label << ", cell " << i;
    }
  }
}

RC_GTEST_PROP(Macrocells, DistancesAreChebyshevs, (uint32_t seed)) {
  std::mt19937 random(seed);
  const glm::uvec3 dims(1 + random() % 60, 1 + random() % 40, 1 + random() % 50);
  const int sparsity = 1 + static_cast<int>(random() % 3000);
  const VolumePtr volume = makeTestVolume(VoxelType::uint8, dims, [&](auto) { return random() % sparsity == 0 ? 200.0 : 0.0; });
  expectDistances(*volume, shownFrom(100.0), "seed " + std::to_string(seed));
  RC_ASSERT(!testing::Test::HasFailure());
}

TEST(Macrocells, DistancesSaturate) {
  // 400 cells in a row, the visible one at an end.
  const VolumePtr volume = makeTestVolume(VoxelType::uint8, {1600, 1, 1}, [](auto p) { return p.x == 0 ? 255.0 : 0.0; });
  expectDistances(*volume, shownFrom(100.0), "row");
  const std::vector<uint8_t> distances = cellsOf(*volume).emptyDistances(tableFor(*volume, shownFrom(100.0)));
  EXPECT_EQ(distances[0], 0);
  EXPECT_EQ(distances[254], 254);
  EXPECT_EQ(distances[399], 255);
}

TEST(Macrocells, NothingAndEverythingVisible) {
  const glm::uvec3 dims(23, 17, 9);
  const VolumePtr volume = makeTestVolume(VoxelType::uint16, dims, blobs(dims, 3));
  for (const uint8_t distance : cellsOf(*volume).emptyDistances(tableFor(*volume, {{{0.0, glm::vec3(1.0f), 0.0f}}})))
    ASSERT_EQ(distance, 255);
  for (const uint8_t distance : cellsOf(*volume).emptyDistances(tableFor(*volume, {{{0.0, glm::vec3(1.0f), 0.1f}}})))
    ASSERT_EQ(distance, 0);
}

/// Ramps and steps over the values of blobs, some in bins that have to be told apart further.
TransferFunction someFunction(std::mt19937& random, double factor) {
  TransferFunction function;
  double value = -10.0;
  for (int i = 0; i < 8; ++i) {
    if (random() % 3 > 0)
      value += random() % 2 ? 1e-3 * static_cast<double>(random() % 1000) : static_cast<double>(random() % 30);
    function.points.push_back(
        {value * factor, glm::vec3(0.5f), random() % 2 ? 0.0f : 0.1f * static_cast<float>(random() % 10)});
  }
  return function;
}

RC_GTEST_PROP(Macrocells, EveryTypeShowsWhatItsTableSays, (uint32_t seed)) {
  std::mt19937 random(seed);
  const glm::uvec3 dims(1 + random() % 70, 1 + random() % 20, 1 + random() % 20);
  const VoxelType type = kAllVoxelTypes[random() % kAllVoxelTypes.size()];
  const bool isFloat = type == VoxelType::float32 || type == VoxelType::float64;
  const double factor = isFloat ? 1e-3 : 1.0;
  const FieldFunction field = blobs(dims, seed);
  const VolumePtr volume = makeTestVolume(type, dims, [&](const glm::ivec3& p) {
    return isFloat && (p.x + 3 * p.y + 7 * p.z) % 11 < 3 && p.x > 5 ? kNan : field(p) * factor;
  });
  expectDistances(*volume, someFunction(random, factor),
                  "seed " + std::to_string(seed) + ", " + std::string(nameOf(type)));
  RC_ASSERT(!testing::Test::HasFailure());
}

TEST(Macrocells, FollowAnotherScale) {
  const glm::uvec3 dims(21, 14, 9);
  const FieldFunction field = blobs(dims, 8);
  for (const VoxelType type : kAllVoxelTypes) {
    const bool isFloat = type == VoxelType::float32 || type == VoxelType::float64;
    const VolumePtr volume =
        makeTestVolume(type, dims, [&](const glm::ivec3& p) { return p.x < 5 && isFloat ? kNan : 20.0 + field(p); });
    const TransferFunction first = shownFrom(25.0), second = shownFrom(70.0);
    const Macrocells cells = cellsFor(*volume, first), fresh = cellsFor(*volume, second);
    const Macrocells scaled = cells.scaledBy(scaleFor(*volume, second));
    ASSERT_EQ(scaled.dims(), fresh.dims());
    for (size_t i = 0; i < fresh.count(); ++i)
      ASSERT_EQ(scaled.range(i), fresh.range(i)) << nameOf(type) << ", cell " << i;
    // Where voxels become interpolants by an origin, and there alone, there is something to make anew.
    const bool hasOrigin = type == VoxelType::int32 || type == VoxelType::uint32 || type == VoxelType::float64;
    EXPECT_EQ(scaled.sharesRangesWith(cells), !hasOrigin) << nameOf(type);
    EXPECT_TRUE(cells.scaledBy(scaleFor(*volume, first)).sharesRangesWith(cells)) << nameOf(type);
    const Macrocells back = scaled.scaledBy(scaleFor(*volume, first));
    for (size_t i = 0; i < cells.count(); ++i)
      ASSERT_EQ(back.range(i), cells.range(i)) << nameOf(type) << ", cell " << i;
  }
}

TEST(Macrocells, TheSmallestValuesThereAre) {
  const VolumePtr volume = makeTestVolume(VoxelType::float64, {8, 8, 8}, [](auto p) { return p.x * 4.9406564584124654e-324; });
  expectRanges(*volume, "denormal");
  expectDistances(*volume, shownFrom(2e-323), "denormal");
}

}  // namespace
}  // namespace warpscope
