// The device's empty cells against the CPU's, byte for byte: every voxel type, functions of ramps, steps and spikes,
// grids of every shape. Mirrors render/march/device_cells.h and device_octants.h.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "render/core/textbook_table.h"
#include "render/core/visible_bins.h"
#include "render/cuda/devices.h"
#include "tests/gpu/agreement.h"
#include "tests/gpu/cells_probe.h"
#include "tests/test_volumes.h"
#include "tests/view_cells.h"

namespace warpscope {
namespace {

void expectSame(const Macrocells& cells, const TransferTable& table, const std::string& label) {
  const std::vector<uint8_t> expected = cells.emptyDistances(table), actual = emptyDistancesOnDevice(cells, table);
  ASSERT_EQ(expected.size(), actual.size()) << label;
  size_t different = 0;
  for (size_t i = 0; i < expected.size(); ++i) different += expected[i] != actual[i];
  ASSERT_EQ(different, 0u) << "of " << expected.size() << ", " << label;
}

/// Ramps and steps, some closer together than a table's bins.
TransferFunction someFunction(std::mt19937& random, double factor) {
  TransferFunction function;
  double value = -10.0;
  for (int i = 0; i < 10; ++i) {
    if (random() % 3 > 0)
      value += random() % 2 ? 1e-3 * static_cast<double>(random() % 1000) : static_cast<double>(random() % 30);
    function.points.push_back(
        {value * factor, glm::vec3(0.5f), random() % 3 ? 0.0f : 0.1f * static_cast<float>(random() % 10)});
  }
  return function;
}

bool isFloating(VoxelType type) { return type == VoxelType::float32 || type == VoxelType::float64; }
/// What floats are small by, so that they are no whole numbers.
double valueFactorOf(VoxelType type) { return isFloating(type) ? 1e-3 : 1.0; }

/// Floats have holes.
VolumePtr blobsOf(VoxelType type, const glm::uvec3& dims) {
  const FieldFunction field = blobs(dims, 11);
  return makeTestVolume(type, dims, [&](const glm::ivec3& p) {
    return isFloating(type) && (p.x + 3 * p.y + 7 * p.z) % 11 < 3 && p.x > 30 ? std::nan("") : field(p) * valueFactorOf(type);
  });
}

TEST(CellsOnDevice, EveryTypeAndManyFunctions) {
  WARPSCOPE_NEEDS_GPU();
  size_t visible = 0, hidden = 0;
  for (const VoxelType type : kAllVoxelTypes) {
    const double factor = valueFactorOf(type);
    for (const glm::uvec3 dims : {glm::uvec3(70, 41, 33), glm::uvec3(9, 80, 5), glm::uvec3(1, 1, 50)}) {
      const VolumePtr volume = blobsOf(type, dims);
      for (uint32_t seed = 0; seed < 12; ++seed) {
        std::mt19937 random(seed);
        const TransferFunction function = someFunction(random, factor);
        const ValueScale scale = valueScaleOf(type, volume->statistics(), function);
        const Macrocells cells(*volume, scale);
        for (const Arithmetic arithmetic : {Arithmetic::stable, Arithmetic::textbook}) {
          const TransferTable table = bakeTransferTable(function, *volume, scale, 0.5f, arithmetic);
          expectSame(cells, table, std::string(nameOf(type)) + ", seed " + std::to_string(seed));
          for (const uint8_t distance : cells.emptyDistances(table)) ++(distance == 0 ? visible : hidden);
        }
      }
    }
  }
  EXPECT_GT(visible, 1000u);
  EXPECT_GT(hidden, 1000u);
}

TEST(CellsOnDevice, DistancesSaturateAlongEveryAxis) {
  WARPSCOPE_NEEDS_GPU();
  for (int axis = 0; axis < 3; ++axis) {
    glm::uvec3 dims(6);
    dims[axis] = 2400;
    const VolumePtr volume = makeTestVolume(VoxelType::uint8, dims, [&](const glm::ivec3& p) {
      return p[axis] == 40 && p[(axis + 1) % 3] == 0 ? 255.0 : 0.0;
    });
    const TransferFunction function{{{100.0, glm::vec3(1.0f), 0.0f}, {100.0, glm::vec3(1.0f), 0.5f}}};
    const ValueScale scale = valueScaleOf(volume->type(), volume->statistics(), function);
    expectSame({*volume, scale}, bakeTransferTable(function, *volume, scale, 0.5f), "axis " + std::to_string(axis));
    expectSame({*volume, scale}, bakeTransferTable({{{0.0, glm::vec3(1.0f), 0.0f}}}, *volume, scale, 0.5f),
               "nothing, axis " + std::to_string(axis));
  }
}

/// Which cells of an edge show anything, 0 for those, by their voxels one by one.
std::vector<uint8_t> marksOf(const Volume& volume, const ValueScale& scale, const TransferTable& table, const glm::ivec3& dims, int edge) {
  const std::vector<int32_t> next = nextVisibleBins(table);
  const VisibleBins bins{table.lookup(), next.data()};
  const glm::ivec3 n(volume.dims());
  std::vector<uint8_t> marks;
  visitVoxelType(volume.type(), [&](auto tag) {
    const auto* const voxels = volume.voxelsAs<decltype(tag)>();
    for (int i = 0; i < dims.x * dims.y * dims.z; ++i) {
      const glm::ivec3 first = edge * glm::ivec3(i % dims.x, i / dims.x % dims.y, i / dims.x / dims.y), last = glm::min(first + edge, n - 1);
      float low = 1.0f, high = 0.0f;
      bool any = false;
      for (int z = first.z; z <= last.z; ++z)
        for (int y = first.y; y <= last.y; ++y)
          for (int x = first.x; x <= last.x; ++x) {
            const auto voxel = voxels[(static_cast<size_t>(z) * n.y + y) * n.x + x];
            if (!isFiniteVoxel(voxel)) continue;
            const float value = interpolant(voxel, scale);
            low = any ? std::min(low, value) : value;
            high = any ? std::max(high, value) : value;
            any = true;
          }
      marks.push_back(anyVisibleBetween(bins, low, high) ? 0 : 1);
    }
  });
  return marks;
}

TEST(OctantsOnDevice, DistancesOfEveryTypeHoldForRaysOfEveryWay) {
  WARPSCOPE_NEEDS_GPU();
  size_t visible = 0, far = 0;
  for (const VoxelType type : kAllVoxelTypes) {
    const double factor = valueFactorOf(type);
    for (const glm::uvec3 dims : {glm::uvec3(70, 41, 33), glm::uvec3(9, 80, 5), glm::uvec3(1, 1, 50), glm::uvec3(1)}) {
      const VolumePtr volume = blobsOf(type, dims);
      for (uint32_t seed = 0; seed < 4; ++seed) {
        std::mt19937 random(seed);
        const TransferFunction function = someFunction(random, factor);
        const ValueScale scale = valueScaleOf(type, volume->statistics(), function);
        const TransferTable table = bakeTransferTable(function, *volume, scale, 0.5f);
        const OctantMaps maps = octantsOnDevice(*volume, scale, table);
        SCOPED_TRACE(::testing::Message() << nameOf(type) << ", " << dims.x << "x" << dims.y << "x" << dims.z << ", seed " << seed);
        EXPECT_TRUE(maps.isOfCells);
        ASSERT_EQ(maps.edge, 2);
        ASSERT_EQ(maps.dims, (glm::ivec3(dims) + 1) / 2);
        const std::vector<uint8_t> marks = marksOf(*volume, scale, table, maps.dims, maps.edge);
        ASSERT_TRUE(maps.distances == octantDistances(marks.data(), maps.dims));
        for (const uint8_t distance : maps.distances) visible += distance == 0, far += distance > 3;
      }
    }
  }
  EXPECT_GT(visible, 1000u);
  EXPECT_GT(far, 1000u);
}

TEST(OctantsOnDevice, LargeVolumesHaveLargerCells) {
  WARPSCOPE_NEEDS_GPU();
  const TransferFunction function{{{100.0, glm::vec3(1.0f), 0.0f}, {100.0, glm::vec3(1.0f), 0.5f}}};
  for (const VoxelType type : {VoxelType::uint8, VoxelType::float32}) {
    const bool isLargest = type == VoxelType::float32;  // too large to be kept in cells
    const glm::uvec3 dims = isLargest ? glm::uvec3(420, 410, 400) : glm::uvec3(400, 300, 310);
    const VolumePtr volume = makeTestVolume(type, dims, [](const glm::ivec3& p) { return p == glm::ivec3(399, 0, 152) ? 200.0 : 3.0; });
    const ValueScale scale = valueScaleOf(type, volume->statistics(), function);
    const TransferTable table = bakeTransferTable(function, *volume, scale, 0.5f);
    const OctantMaps maps = octantsOnDevice(*volume, scale, table);
    EXPECT_EQ(maps.isOfCells, !isLargest);
    ASSERT_EQ(maps.edge, 4);
    ASSERT_EQ(maps.dims, (glm::ivec3(dims) + 3) / 4);
    const std::vector<uint8_t> marks = marksOf(*volume, scale, table, maps.dims, maps.edge);
    EXPECT_EQ(std::count(marks.begin(), marks.end(), 0), 2);  // a voxel that two cells share
    EXPECT_TRUE(maps.distances == octantDistances(marks.data(), maps.dims));
  }
}

}  // namespace
}  // namespace warpscope
