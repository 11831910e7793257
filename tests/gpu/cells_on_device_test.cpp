// The device's empty cells against the CPU's, byte for byte: every voxel type, functions of ramps, steps and spikes,
// grids of every shape. Mirrors render/march/device_cells.h.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "render/core/textbook_table.h"
#include "render/cuda/devices.h"
#include "tests/gpu/agreement.h"
#include "tests/gpu/cells_probe.h"
#include "tests/test_volumes.h"

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

TEST(CellsOnDevice, EveryTypeAndManyFunctions) {
  WARPSCOPE_NEEDS_GPU();
  size_t visible = 0, hidden = 0;
  for (const VoxelType type : kAllVoxelTypes) {
    const bool isFloat = type == VoxelType::float32 || type == VoxelType::float64;
    const double factor = isFloat ? 1e-3 : 1.0;
    for (const glm::uvec3 dims : {glm::uvec3(70, 41, 33), glm::uvec3(9, 80, 5), glm::uvec3(1, 1, 50)}) {
      const FieldFunction field = blobs(dims, 11);
      const VolumePtr volume = makeTestVolume(type, dims, [&](const glm::ivec3& p) {
        return isFloat && (p.x + 3 * p.y + 7 * p.z) % 11 < 3 && p.x > 30 ? std::nan("") : field(p) * factor;
      });
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

}  // namespace
}  // namespace warpscope
