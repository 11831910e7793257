// Where a sample's fields lie, which quantisations are usable, and the unit of radii. What quantising does: stability/samples_test.cpp.
// Mirrors render/core/sample.h and pixel_grid.h.
#include "render/core/sample.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

namespace warpscope {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

TEST(PixelGrid, BoxesThatAreNotInFrontHaveNoDepths) {
  Camera camera;
  camera.width = camera.height = 8;
  EXPECT_EQ(depthRangeOf(camera, {}).farDepth, 0.0f);
  const DepthRange behind = depthRangeOf(camera, {glm::vec3(2.0f), glm::vec3(3.0f)});
  EXPECT_EQ(behind.nearDepth, 0.0f);
  EXPECT_EQ(behind.farDepth, 0.0f);
  EXPECT_TRUE(isUsable(quantizationFor(camera, {glm::vec3(2.0f), glm::vec3(3.0f)}, 1.0f)));
  EXPECT_TRUE(isUsable(quantizationFor(camera, {glm::vec3(0.0f), glm::vec3(0.0f)}, 1.0f)));
}

TEST(SampleQuantization, WhatIsNoneIsNotUsable) {
  const SampleQuantization good{{glm::vec3(-1.0f), glm::vec3(1.0f)}, 0.5f, 0.0f, 0.25f};
  EXPECT_TRUE(isUsable(good));
  const auto isUsableWith = [&](auto change) {
    SampleQuantization q = good;
    change(q);
    return isUsable(q);
  };
  EXPECT_FALSE(isUsable(SampleQuantization{}));  // bounds that hold nothing
  for (const float bad : {kNan, kInfinity, -1.0f}) {
    EXPECT_FALSE(isUsableWith([&](auto& q) { q.nearDepth = bad; })) << bad;
    EXPECT_FALSE(isUsableWith([&](auto& q) { q.depthStep = bad; })) << bad;
    EXPECT_FALSE(isUsableWith([&](auto& q) { q.radiusUnit = bad; })) << bad;
  }
  EXPECT_FALSE(isUsableWith([](auto& q) { q.depthStep = 0.0f; }));
  EXPECT_FALSE(isUsableWith([](auto& q) { q.radiusUnit = 3.0f; }));
  EXPECT_FALSE(isUsableWith([](auto& q) { q.bounds.lower.y = 2.0f; }));
  EXPECT_FALSE(isUsableWith([](auto& q) { q.bounds.upper.y = kInfinity; }));
}

TEST(SampleRadius, UnitLeavesRoomForTheLargest) {
  for (const float largest : {1.0f, 0.75f, 0.8660254f, 1.9999999f, 2.0f, 1e-20f, 1e20f, 3e38f}) {
    const float unit = radiusUnitFor(largest);
    EXPECT_EQ(std::exp2(std::round(std::log2(unit))), unit) << largest;
    EXPECT_LE(unit, largest);
    EXPECT_GT(static_cast<double>(unit) * 2.0, largest);
    EXPECT_GT(decodeRadius(encodeRadius(largest, unit), unit), largest * (1.0f - 1.0f / 64.0f));
  }
  for (const float none : {0.0f, -1.0f, kNan, kInfinity}) EXPECT_EQ(radiusUnitFor(none), 1.0f);
}

TEST(PackedSample, FieldsLieWhereTheHeaderSays) {
  const PackedSample sample = packSample(1, 2, 3.0f, 1.5f, SampleQuantization{});
  EXPECT_EQ(sample & 0x3fff, 1u);
  EXPECT_EQ(sample >> 14 & 0x3fff, 2u);
  EXPECT_EQ(sample >> 28 & 0x3ffffff, 3u);
  EXPECT_EQ(sample >> 54, 15u << 6 | 32u);
  EXPECT_EQ(radiusCode(sample), 15u << 6 | 32u);
  EXPECT_EQ(packCodes(16383, 16383, kDepthCodeMax, kRadiusCodeMax), ~PackedSample{0});
  EXPECT_EQ(radiusCode(packSample(0, 0, kNan, kNan, SampleQuantization{})), 1u);
  // Pixels as numbers rise in their order.
  EXPECT_LT(pixelKey(16383, 4), pixelKey(0, 5));
  EXPECT_EQ(pixelKey(sample), pixelKey(1, 2));
}

RC_GTEST_PROP(PackedSample, UnpackingIsTheInverseOfPacking, (uint32_t seed)) {
  std::mt19937_64 random(seed);
  const SampleQuantization q{{{-88.0f, -64.0f, -3.5f}, {88.0f, 64.0f, 3.5f}}, 2.0f, 100.0f, 1e-3f};
  for (int i = 0; i < 100; ++i) {
    const PackedSample sample = random() & ~(PackedSample{15} << 50);  // 22 bits of depth
    if (radiusCode(sample) == 0) continue;
    const float behind = decodeDepth(depthCode(sample), q.depthStep), radius = decodeRadius(radiusCode(sample), q.radiusUnit);
    RC_ASSERT(packSample(columnOf(sample), rowOf(sample), behind, radius, q) == sample);
  }
}

}  // namespace
}  // namespace warpscope
