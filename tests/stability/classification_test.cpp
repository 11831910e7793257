// What a transfer function shows, through the marcher: cases 41, 43 and 59 to 61. Truth: the function as it was
// written. Mirrors render/march/marcher.h. The tables behind it: transfer_table_test.cpp, value_scale_test.cpp.
#include <gtest/gtest.h>

#include <cmath>
#include <utility>
#include <vector>

#include "tests/marcher_cases.h"
#include "tests/stability/backends.h"
#include "tests/stability/record.h"
#include "tests/stability/written_function.h"
#include "tests/test_volumes.h"

namespace warpscope {
namespace {

Image<glm::vec4> pictureOf(Backend backend, const VolumePtr& volume, const TransferFunction& function,
                           const MarchSettings& settings = {}) {
  return rendered(*marcherOn(backend, volume, function), lookingFrom({20.0f, 9.0f, 15.0f}, {}, 24, 24), settings);
}

/// Which of the values a marcher shows: each fills a column of its own, seen through its middle.
std::vector<bool> shownColumns(Backend backend, VoxelType type, const std::vector<double>& values,
                               const TransferFunction& function) {
  const auto count = static_cast<uint32_t>(values.size());
  const VolumePtr volume = makeTestVolume(type, {8 * count, 8, 8},
                                          [&](const glm::ivec3& p) { return values[static_cast<size_t>(p.x / 8)]; });
  const MarcherPtr marcher = marcherOn(backend, volume, function);
  std::vector<bool> shown;
  for (uint32_t i = 0; i < count; ++i) {
    const float x = 8.0f * (static_cast<float>(i) + 0.5f) - 4.0f * static_cast<float>(count);
    const float alpha = rendered(*marcher, lookingFrom({x, 0.0f, 60.0f}, {x, 0.0f, 0.0f}, 1, 1, 1e-3f))(0, 0).a;
    EXPECT_TRUE(alpha == 0.0f || alpha > 0.99f) << values[i] << ": " << alpha;
    shown.push_back(alpha > 0.0f);
  }
  return shown;
}

TEST_P(Case43, RepeatedCornersAreAStep) {
  const TransferFunction function{{{0.0, glm::vec3(1.0f), 0.0f},
                                   {50.0, glm::vec3(1.0f), 0.0f},
                                   {50.0, glm::vec3(1.0f), 1.0f},
                                   {51.0, glm::vec3(1.0f), 1.0f},
                                   {51.0, glm::vec3(1.0f), 0.0f}}};
  for (const VoxelType type : kAllVoxelTypes)
    EXPECT_EQ(shownColumns(GetParam(), type, {49.0, 50.0, 51.0, 0.0}, function),
              std::vector<bool>({false, true, false, false}))
        << nameOf(type);
  recordExact("march by a function of repeated corners", "the written function", GetParam());
}

TEST_P(Case59, LabelsAndOutliersAreShownAsWritten) {
  for (const double label : {1.0, 255.0, 30001.0, 65534.0}) {
    const TransferFunction needle{
        {{label - 0.5, glm::vec3(1.0f), 0.0f}, {label, glm::vec3(1.0f), 1.0f}, {label + 0.5, glm::vec3(1.0f), 0.0f}}};
    EXPECT_EQ(shownColumns(GetParam(), VoxelType::uint16, {0.0, label - 1.0, label, label + 1.0, 65535.0}, needle),
              std::vector<bool>({false, false, true, false, false}))
        << label;
  }
  for (const double outlier : {-9999.0, 1e30}) {
    const TransferFunction band{{{0.3, glm::vec3(1.0f), 0.0f},
                                 {0.3, glm::vec3(1.0f), 1.0f},
                                 {0.6, glm::vec3(1.0f), 1.0f},
                                 {0.6, glm::vec3(1.0f), 0.0f}}};
    EXPECT_EQ(shownColumns(GetParam(), VoxelType::float32, {outlier, 0.25, 0.35, 0.55, 0.65}, band),
              std::vector<bool>({false, false, true, true, false}))
        << outlier;
  }
  recordExact("march of a label among 65536 and of data beside outliers", "the written function", GetParam());
}

TEST_P(Case60, RangesOfAFewValuesAreShownAsWritten) {
  for (const auto& [type, least] : {std::pair(VoxelType::int16, -32768.0),
                                    {VoxelType::uint16, 65532.0},
                                    {VoxelType::int32, 2147483644.0},
                                    {VoxelType::uint32, 4294967292.0}})
    for (int from = 0; from < 4; ++from) {
      std::vector<bool> expected;
      for (int i = 0; i < 4; ++i) expected.push_back(i >= from);
      EXPECT_EQ(shownColumns(GetParam(), type, {least, least + 1.0, least + 2.0, least + 3.0}, stepAt(least + from)),
                expected)
          << nameOf(type) << " from " << from;
    }
  recordExact("march of ranges of 4 values at the ends of types", "the written function", GetParam());
}

TEST_P(Case41, ACubeOfOneInZeroIsShown) {
  const auto cube = [](double inside, double outside) {
    return [=](const glm::ivec3& p) {
      return glm::all(glm::greaterThan(p, glm::ivec3(2))) && glm::all(glm::lessThan(p, glm::ivec3(6))) ? inside
                                                                                                       : outside;
    };
  };
  for (const VoxelType type : kAllVoxelTypes)
    EXPECT_GT(largestAlpha(pictureOf(GetParam(), makeTestVolume(type, glm::uvec3(9), cube(1, 0)), stepAt(1.0))), 0.99f)
        << nameOf(type);
  EXPECT_GT(largestAlpha(pictureOf(GetParam(), makeTestVolume(VoxelType::int16, glm::uvec3(9), cube(-32764, -32767)),
                                   stepAt(-32764.0))),
            0.99f);
  EXPECT_GT(largestAlpha(pictureOf(GetParam(), makeTestVolume(VoxelType::uint16, glm::uvec3(9), cube(65535, 0)),
                                   stepAt(65535.0))),
            0.99f);
  EXPECT_EQ(largestAlpha(pictureOf(GetParam(), makeTestVolume(VoxelType::uint16, glm::uvec3(9), cube(65534, 0)),
                                   stepAt(65535.0))),
            0.0f);
  recordExact("march of a cube of one in zero, of every type", "the written function", GetParam());
}

// --- Case 61: the last, partial step

TEST_P(Case61, AWholeStepThatSaturatesThenAPartialOne) {
  // One voxel, seen through its middle along an axis.
  Worst worst;
  for (const float alpha : {0.9f, 0.0003f, 0.5f, 0.999f, 1e-6f})
    for (const float step : {0.25f, 1.0f, 3.0f, 8.0f, 100.0f, 1e4f}) {
      const VolumePtr volume = makeTestVolume(VoxelType::uint8, glm::uvec3(1), [](const glm::ivec3&) { return 5.0; });
      MarchSettings settings;
      settings.render.step = std::min(step, 1000.0f);
      settings.render.contribution = 1e-6f;
      const Camera camera = lookingFrom({0.0f, 0.0f, 5.0f}, {}, 1, 1);
      const Image<glm::vec4> image = rendered(*marcherOn(GetParam(), volume, everywhere(alpha)), camera, settings);
      worst.see(std::abs(static_cast<double>(image(0, 0).a) - static_cast<double>(alpha)) /
                (1e-6 * static_cast<double>(alpha) + 1e-7));
      EXPECT_NEAR(image(0, 0).r, image(0, 0).a, 1e-6) << "step " << step;
    }
  record({"march by steps that saturate, then a part of one", "closed form", "of 1e-6 of the opacity and 1e-7",
          worst.value(), 1.0, GetParam()});
}

}  // namespace
}  // namespace warpscope
