// Tables of volumes' values: cases 42, 59 and 60. Truth: the function as it was written, in double, by brute force over
// values. Mirrors render/volume/value_scale.h. Tables by themselves: transfer_table_test.cpp.
#include "render/volume/value_scale.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "tests/stability/record.h"
#include "tests/stability/written_function.h"
#include "tests/test_volumes.h"

namespace warpscope {
namespace {

TEST(Case59, OutliersInDataOfZeroToOne) {
  const TransferFunction function{{{0.0, {0, 0, 1}, 0.0f},
                                   {0.3, {1, 0, 0}, 0.0f},
                                   {0.31, {1, 1, 0}, 0.5f},
                                   {0.6, {0, 1, 1}, 0.02f},
                                   {0.6, {1, 1, 1}, 0.9f}}};
  for (const double outlier : {-9999.0, 1e30, -1e30, 3.4e38, 7.0}) {
    for (const VoxelType type : {VoxelType::float32, VoxelType::float64}) {
      const VolumePtr volume = makeTestVolume(type, {2, 2, 2}, [&](const glm::ivec3& p) {
        return p == glm::ivec3(0) ? outlier : 0.125 * (p.x + 2 * p.y + 4 * p.z);
      });
      const ValueScale scale = valueScaleOf(type, volume->statistics(), function);
      const TransferTable table = bakeTransferTable(function, *volume, scale, 0.5f);
      TransferFunction ofInterpolants = function;
      for (TransferPoint& point : ofInterpolants.points)
        point.value = static_cast<double>(static_cast<float>(scale.interpolantOf(point.value)));
      std::mt19937 random(59);
      std::uniform_real_distribution<double> unit(-0.1, 1.1);
      for (int i = 0; i < 20000; ++i) {
        const double value = i < 1000 ? 0.299 + 0.012 * i / 1000.0 : unit(random);
        const auto x = static_cast<float>(
            scale.interpolantOf(type == VoxelType::float32 ? static_cast<double>(static_cast<float>(value)) : value));
        // The corners may be an ulp off: a value that close may be on either side.
        const bool isTie =
            std::any_of(ofInterpolants.points.begin(), ofInterpolants.points.end(), [&](const TransferPoint& point) {
              return std::abs(static_cast<double>(x) - point.value) <= std::abs(point.value) * 1.2e-7;
            });
        if (!isTie) ASSERT_EQ(wrongBeyondTheBound(table, ofInterpolants, x), "") << nameOf(type) << " with " << outlier;
      }
      EXPECT_EQ(shownBy(table, static_cast<float>(scale.interpolantOf(outlier))).color,
                written(function, outlier, 0.5f).color)
          << outlier;
    }
  }
  recordExact("TransferTable, outliers of -9999 to 1e30 in 0 to 1, within kMostVariation", "the written function");
}

TEST(Case60, RangesOfAFewValuesAnywhereInATypeEndAsWritten) {
  std::mt19937_64 random(60);
  const auto check = [&](VoxelType type, int64_t least, int64_t greatest) {
    for (int round = 0; round < 400; ++round) {
      const auto count = static_cast<int64_t>(random() % 10);  // values beside the first
      const int64_t lower =
          round == 0   ? least
          : round == 1 ? greatest - count
                       : least + static_cast<int64_t>(random() % static_cast<uint64_t>(greatest - least - count));
      const VolumePtr volume = makeTestVolume(type, {static_cast<unsigned>(count) + 1, 1, 1},
                                              [&](const glm::ivec3& p) { return static_cast<double>(lower + p.x); });
      for (int64_t shown = lower; shown <= lower + count; ++shown) {
        const TransferFunction function = stepAt(static_cast<double>(shown));
        const ValueScale scale = valueScaleOf(type, volume->statistics(), function);
        const TransferTable table = bakeTransferTable(function, *volume, scale, 1.0f);
        for (int64_t value = lower; value <= lower + count; ++value)
          ASSERT_EQ(shownBy(table, static_cast<float>(scale.interpolantOf(static_cast<double>(value)))).color.a,
                    value >= shown ? 1.0f : 0.0f)
              << "seed 60: " << nameOf(type) << " " << lower << " to " << lower + count << ", shown from " << shown
              << ", at " << value;
      }
    }
  };
  check(VoxelType::int16, -32768, 32767);
  check(VoxelType::uint16, 0, 65535);
  check(VoxelType::int32, std::numeric_limits<int32_t>::lowest(), std::numeric_limits<int32_t>::max());
  check(VoxelType::uint32, 0, std::numeric_limits<uint32_t>::max());
  recordExact("TransferTable, ranges of 1 to 10 values of 16 and 32 bits", "the written function");
}

TEST(Case60, LabelsOf32BitsBesideAnOutlier) {
  for (const double outlier : {-2147483648.0, 2147483647.0}) {
    const VolumePtr volume = makeTestVolume(VoxelType::int32, {3, 1, 1},
                                            [&](const glm::ivec3& p) { return p.x == 0 ? outlier : 1000.0 + p.x; });
    const TransferFunction function{{{-2147483648.0, glm::vec3(1.0f), 0.0f},
                                     {1002.0, glm::vec3(1.0f), 0.0f},
                                     {1002.0, glm::vec3(1.0f), 1.0f},
                                     {1003.0, glm::vec3(1.0f), 1.0f},
                                     {1003.0, glm::vec3(1.0f), 0.0f},
                                     {2147483647.0, glm::vec3(1.0f), 0.0f}}};
    const ValueScale scale = valueScaleOf(VoxelType::int32, volume->statistics(), function);
    const TransferTable table = bakeTransferTable(function, *volume, scale, 1.0f);
    for (const double value : {outlier, 1001.0, 1002.0, 1003.0, 1004.0})
      EXPECT_EQ(shownBy(table, static_cast<float>(scale.interpolantOf(value))).color.a, value == 1002.0 ? 1.0f : 0.0f)
          << value << " beside " << outlier;
  }
  recordExact("TransferTable, labels of 32 bits beside an outlier", "the written function");
}

TEST(Case42, DoublesFromTheLeastToTheGreatest) {
  for (const double size :
       {5e-324, 5.6e-309, 1e-306, 1e-300, 1e-40, 1.0, 1e40, 1e300, std::numeric_limits<double>::max()}) {
    const VolumePtr volume =
        makeTestVolume(VoxelType::float64, {3, 1, 1}, [&](const glm::ivec3& p) { return size * (p.x - 1); });
    for (const double at : {-size, 0.0, size}) {
      const TransferFunction function = stepAt(at);
      const ValueScale scale = valueScaleOf(VoxelType::float64, volume->statistics(), function);
      const TransferTable table = bakeTransferTable(function, *volume, scale, 1.0f);
      for (const double value : {-size, 0.0, size})
        EXPECT_EQ(shownBy(table, interpolant(value, scale)).color.a, value >= at ? 1.0f : 0.0f)
            << value << ", shown from " << at;
    }
    const auto& histogram = volume->statistics().histogram;
    EXPECT_EQ(histogram.front(), 1u) << size;
    EXPECT_EQ(histogram[127] + histogram[128], 1u) << size;  // at a border
    EXPECT_EQ(histogram.back(), 1u) << size;
  }
  recordExact("ValueScale of doubles from 5e-324 to 1.8e308", "the written function");
}

}  // namespace
}  // namespace warpscope
