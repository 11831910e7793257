// Transfer functions made from histograms: always valid, background transparent, what there is to see shown.
// Mirrors app/scene/auto_transfer_function.h.
#include "app/scene/auto_transfer_function.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "render/core/color.h"
#include "render/volume/procedural.h"
#include "test_volumes.h"

namespace warpscope {
namespace {

constexpr double kMax = std::numeric_limits<double>::max();

/// Of linear RGB, as Rec. 709 weighs it.
float luminance(const glm::vec3& color) { return glm::dot(color, glm::vec3(0.2126f, 0.7152f, 0.0722f)); }

/// How far a colour is from grey: the spread of its channels as sRGB. Red, or any other colour that reads as a finding, has 0.5 and more.
float chroma(const glm::vec3& color) {
  const glm::vec3 srgb(srgbFromLinear(color.r), srgbFromLinear(color.g), srgbFromLinear(color.b));
  return std::max({srgb.r, srgb.g, srgb.b}) - std::min({srgb.r, srgb.g, srgb.b});
}

void expectValid(const TransferFunction& function, const std::string& label) {
  ASSERT_FALSE(function.points.empty()) << label;
  for (size_t i = 0; i < function.points.size(); ++i) {
    const TransferPoint& point = function.points[i];
    ASSERT_TRUE(std::isfinite(point.value)) << label;
    ASSERT_GE(point.alpha, 0.0f) << label;
    ASSERT_LE(point.alpha, 1.0f) << label;
    for (int c = 0; c < 3; ++c) ASSERT_TRUE(point.color[c] >= 0.0f && point.color[c] <= 1.0f) << label;
    ASSERT_LT(chroma(point.color), 0.16f) << label;
    if (i > 0) {
      ASSERT_GE(point.value, function.points[i - 1].value) << label;
      ASSERT_GE(point.alpha, function.points[i - 1].alpha) << label;
      ASSERT_GE(luminance(point.color), luminance(function.points[i - 1].color)) << label;
    }
  }
}

TEST(AutoTransferFunction, ValidForAnyHistogram) {
  std::mt19937_64 random(12);
  for (int round = 0; round < 500; ++round) {
    VoxelStatistics statistics;
    statistics.rangeLower = -static_cast<double>(random() % 1000);
    statistics.rangeUpper = statistics.rangeLower + std::exp2(static_cast<double>(random() % 100) - 50.0);
    statistics.lowest = statistics.rangeLower;
    statistics.highest = statistics.rangeUpper;
    const size_t filled = random() % 20;
    for (size_t i = 0; i < filled; ++i) statistics.histogram[random() % 256] = random() >> (random() % 60 + 4);
    expectValid(autoTransferFunction(statistics), "seed 12, round " + std::to_string(round));
  }
}

TEST(AutoTransferFunction, ValidForTheWidestAndNarrowestRanges) {
  for (const auto& [lower, upper] : {std::pair{-kMax, kMax}, {0.0, kMax}, {1e300, 1.0001e300}, {0.0, 4.9406564584124654e-324},
                                     {1e15, 1e15 + 1.0}, {5.0, 5.0}, {-kMax, -kMax}}) {
    VoxelStatistics statistics;
    statistics.rangeLower = statistics.lowest = lower;
    statistics.rangeUpper = statistics.highest = upper;
    statistics.histogram[0] = 900;
    statistics.histogram[255] = 100;
    const TransferFunction function = autoTransferFunction(statistics);
    expectValid(function, std::to_string(lower));
    EXPECT_TRUE(std::isfinite(function.at(0.5 * lower + 0.5 * upper).a)) << lower;
  }
}

TEST(AutoTransferFunction, TwoMaterialsAreToldApart) {
  // Air about 20, matter about 140, with noise on both.
  std::mt19937 random(13);
  std::normal_distribution<double> air(20.0, 4.0), matter(140.0, 10.0);
  const VolumePtr volume = makeTestVolume(VoxelType::uint8, {40, 40, 40}, [&](const glm::ivec3& p) {
    const bool inside = glm::length(glm::vec3(p) - 20.0f) < 12.0f;
    return std::min(255.0, std::max(0.0, inside ? matter(random) : air(random)));
  });
  const TransferFunction function = autoTransferFunction(volume->statistics());
  for (int value = 0; value <= 30; ++value) EXPECT_EQ(function.at(value).a, 0.0f) << value;
  EXPECT_GT(function.at(140.0).a, 0.1f);
  EXPECT_GT(function.at(165.0).a, function.at(120.0).a);
}

TEST(AutoTransferFunction, TheRarestValuesAreTheLightest) {
  VoxelStatistics statistics;
  statistics.rangeUpper = statistics.highest = 255.0;
  statistics.histogram.fill(1000);
  const TransferFunction function = autoTransferFunction(statistics);
  for (size_t i = 2; i < function.points.size(); ++i) {  // the first two are one colour: where opacity begins, and where it has risen
    EXPECT_GT(luminance(function.points[i].color), luminance(function.points[i - 1].color)) << i;
    EXPECT_GT(function.points[i].alpha, function.points[i - 1].alpha) << i;
  }
  EXPECT_GT(luminance(function.at(255.0)), 0.8f);
}

TEST(AutoTransferFunction, VolumesOfOneValueAreFaintlyVisibleAndAlike) {
  for (const VoxelType type : kAllVoxelTypes) {
    const VolumePtr volume = makeTestVolume(type, {4, 4, 4}, [](auto) { return 42.0; });
    EXPECT_EQ(autoTransferFunction(volume->statistics()).at(42.0).a, 0.02f) << nameOf(type);
  }
  const VolumePtr none = makeTestVolume(VoxelType::float32, {4, 4, 4}, [](auto) { return std::nan(""); });
  expectValid(autoTransferFunction(none->statistics()), "no finite voxel");
}

TEST(AutoTransferFunction, ShowsSomethingOfEveryProceduralVolume) {
  for (const ProceduralVolume& procedural : kProceduralVolumes) {
    const VolumePtr volume = makeProceduralVolume(procedural.name, procedural.defaultDims / 4u);
    const TransferFunction function = autoTransferFunction(volume->statistics());
    expectValid(function, std::string(procedural.name));
    EXPECT_GT(function.at(volume->statistics().highest).a, 0.3f) << procedural.name;
    EXPECT_EQ(function.at(volume->statistics().lowest).a, 0.0f) << procedural.name;
  }
}

}  // namespace
}  // namespace warpscope
