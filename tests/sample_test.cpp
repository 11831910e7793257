// What quantising positions and radii may do to a sample, in flat bounds too.
// Mirrors render/core/sample.h; truth in long double from the bits that the header documents.
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

/// Steps of depth as they occur, and far beyond.
constexpr float kSteps[] = {1.0f, 0x1p-18f, 1e-3f, 0.0007123f, 3e10f, 1e-30f, 7e-12f};

RC_GTEST_PROP(SampleDepth, AtMostHalfAStepOff, (uint32_t seed)) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> exponent(-2.0f, 25.9f);
  for (const float step : kSteps)
    for (int i = 0; i < 300; ++i) {
      const float behind = step * std::exp2(exponent(random));
      const long double back = decodeDepth(encodeDepth(behind, step), step);
      // The quotient is rounded, and what the code stands for.
      RC_ASSERT(std::abs(back - behind) <= 0.5L * step + 0x1p-22L * behind);
    }
}

TEST(SampleDepth, EveryCodeThatFramesHaveComesBack) {
  for (const float step : kSteps) {
    float before = -1.0f;
    for (uint32_t code = 0; code <= 1u << 22; code += 1 + code / 1000) {
      const float behind = decodeDepth(code, step);
      ASSERT_EQ(encodeDepth(behind, step), code) << step;
      ASSERT_GT(behind, before) << code;
      before = behind;
    }
  }
  // With a step that is a power of two all that floats can tell apart.
  for (const uint32_t first : {1u << 22, 1u << 23, (1u << 24) - 1000})
    for (uint32_t code = first; code < first + 1000; ++code) ASSERT_EQ(encodeDepth(decodeDepth(code, 0.25f), 0.25f), code);
}

TEST(SampleDepth, OutsideIsClampedAndNanIsNothing) {
  for (const float behind : {0.0f, -0.0f, -1.0f, -kInfinity, kNan}) EXPECT_EQ(encodeDepth(behind, 0.5f), 0u) << behind;
  for (const float behind : {0x1p26f, 3e38f, kInfinity}) {
    EXPECT_LE(encodeDepth(behind, 1.0f), kDepthCodeMax) << behind;
    EXPECT_GE(encodeDepth(behind, 1.0f), kDepthCodeMax - 3) << behind;
  }
  for (const float step : {0.0f, -1.0f, kNan, kInfinity}) EXPECT_LE(encodeDepth(3.0f, step), kDepthCodeMax) << step;
}

/// A camera that looks at the origin from `distance`, somewhere around it.
Camera someCamera(std::mt19937& random, float distance, uint32_t width, uint32_t height) {
  std::uniform_real_distribution<float> unit(-1.0f, 1.0f);
  Camera camera;
  camera.forward = glm::normalize(glm::vec3(unit(random), unit(random), unit(random)) + glm::vec3(0.0f, 0.0f, 1e-3f));
  const glm::vec3 up = std::abs(camera.forward.y) > 0.9f ? glm::vec3(0.0f, 0.0f, 1.0f) : glm::vec3(0.0f, 1.0f, 0.0f);
  camera.right = glm::normalize(glm::cross(camera.forward, up));
  camera.up = glm::cross(camera.right, camera.forward);
  camera.eye = -distance * camera.forward;
  camera.tanHalfFovY = distance > 2.0f ? 1.0f / distance : 0.5f;
  camera.width = width;
  camera.height = height;
  return camera;
}

RC_GTEST_PROP(SamplePosition, LiesOnItsPixelsRayAsPreciselyAsDeclared, (uint32_t seed)) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> unit(0.0f, 1.0f);
  for (const float size : {1e-3f, 1.0f, 300.0f})
    for (const float distance : {0.05f, 0.7f, 3.0f, 1e3f, 1e5f, 4e6f}) {
      const Box bounds{glm::vec3(-0.5f * size), glm::vec3(0.5f * size)};
      const Camera camera = someCamera(random, distance * size, 1 + random() % 16384, 1 + random() % 16384);
      const SampleQuantization q = quantizationFor(camera, bounds, 1.0f);
      RC_ASSERT(isUsable(q));
      const SampleGrid grid = makeSampleGrid(camera, q);
      const DepthRange depths = depthRangeOf(camera, bounds);
      const glm::dvec3 anchor = glm::dvec3(camera.eye) + static_cast<double>(q.nearDepth) * glm::dvec3(camera.forward);
      const double edge = static_cast<double>(pixelEdge(camera));
      for (int i = 0; i < 50; ++i) {
        const auto column = static_cast<uint32_t>(random() % camera.width), row = static_cast<uint32_t>(random() % camera.height);
        const float behind = unit(random) * (depths.farDepth - depths.nearDepth);
        const PackedSample sample = packSample(column, row, behind, 0.25f, q);
        RC_ASSERT(columnOf(sample) == column);
        RC_ASSERT(rowOf(sample) == row);
        const double stored = static_cast<double>(depthCode(sample)) * static_cast<double>(q.depthStep);
        RC_ASSERT(std::abs(stored - behind) <= 0.51 * static_cast<double>(q.depthStep));
        const glm::dvec3 across = (column + 0.5 - 0.5 * camera.width) * edge * glm::dvec3(camera.right) +
                                  (0.5 * camera.height - row - 0.5) * edge * glm::dvec3(camera.up);
        const double l = glm::length(across) * (static_cast<double>(q.nearDepth) + stored);
        const glm::dvec3 expected = anchor + stored * glm::dvec3(camera.forward) + (static_cast<double>(q.nearDepth) + stored) * across;
        const glm::vec3 position = grid.pixels.at(column, row, decodeDepth(depthCode(sample), q.depthStep));
        const double bound = 0x1p-21 * (glm::length(anchor) + stored + l);
        for (int axis = 0; axis < 3; ++axis) RC_ASSERT(std::abs(static_cast<double>(position[axis]) - expected[axis]) <= bound);
        const Sphere sphere = unpackSample(sample, grid);
        for (int axis = 0; axis < 3; ++axis) {
          RC_ASSERT(sphere.center[axis] == std::clamp(position[axis], bounds.lower[axis], bounds.upper[axis]));
        }
      }
    }
}

RC_GTEST_PROP(PixelGrid, NoRayBeginsBehindTheBoxsFrontUnlessTheEyeDoes, (uint32_t seed)) {
  std::mt19937 random(seed);
  for (const float distance : {0.0f, 0.3f, 0.9f, 2.0f, 1e3f, 1e5f, 4e6f}) {
    const Box bounds{{-0.5f, -0.25f, -0.4f}, {0.5f, 0.25f, 0.4f}};
    const Camera camera = someCamera(random, distance, 64, 48);
    const DepthRange depths = depthRangeOf(camera, bounds);
    const PixelGrid grid = makePixelGrid(camera, depths.nearDepth);
    // Depth is a coordinate along axes that rounding has left not quite orthonormal.
    const glm::dmat3 fromAxes = glm::inverse(glm::dmat3(camera.right, camera.up, camera.forward));
    RC_ASSERT(depths.nearDepth >= 0.0f);
    RC_ASSERT(depths.farDepth >= depths.nearDepth);
    RC_ASSERT(depths.farDepth - depths.nearDepth <= 1.4f + 2.0f * 0x1p-23f * distance);
    for (int corner = 0; corner < 8; ++corner) {
      const glm::dvec3 point(glm::vec3(corner & 1 ? bounds.upper.x : bounds.lower.x, corner & 2 ? bounds.upper.y : bounds.lower.y,
                                       corner & 4 ? bounds.upper.z : bounds.lower.z));
      RC_ASSERT((fromAxes * (point - glm::dvec3(camera.eye))).z <= static_cast<double>(depths.farDepth));
      // From the rounded plane itself, where rays are.
      if (depths.nearDepth > 0.0f) RC_ASSERT((fromAxes * (point - glm::dvec3(grid.anchor))).z >= 0.0);
    }
    const PixelRay ray = grid.ray(13, 40);
    RC_ASSERT(ray.ray.direction == pixelRay(camera, {13.5f, 40.5f}).direction);
    RC_ASSERT(std::abs(ray.cosine - glm::dot(ray.ray.direction, camera.forward)) < 1e-6f);
    if (depths.nearDepth == 0.0f) RC_ASSERT(ray.ray.origin == camera.eye);
  }
}

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

TEST(SamplePosition, NeverOutsideTheBoundsWhateverTheBits) {
  std::mt19937_64 random(5);
  for (const float bad : {kNan, kInfinity, 0.0f, 1e38f, 1e-30f, 1.0f}) {
    SampleGrid grid;
    grid.pixels.anchor = glm::vec3(bad, 0.0f, -bad);
    grid.pixels.edge = bad;
    grid.pixels.nearDepth = bad;
    grid.depthStep = bad;
    grid.bounds = {{-4.0f, 2.0f, -8.0f}, {4.0f, 2.0f, 8.0f}};  // flat
    for (int i = 0; i < 1000; ++i) {
      const glm::vec3 position = unpackPosition(random(), grid);
      for (int axis = 0; axis < 3; ++axis)
        ASSERT_TRUE(position[axis] >= grid.bounds.lower[axis] && position[axis] <= grid.bounds.upper[axis]) << bad;
    }
  }
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

TEST(SampleRadius, AllCodesFollowTheDocumentedFormulaAndRiseAndComeBack) {
  for (const float unit : {1.0f, 0.25f, 0x1p-60f, 0x1p40f}) {
    float before = 0.0f;
    for (uint32_t code = 1; code <= kRadiusCodeMax; ++code) {
      const float radius = decodeRadius(code, unit);
      const long double exact = unit * std::exp2(static_cast<long double>(code >> 6) - 15.0L) * (1.0L + (code & 63) / 64.0L);
      ASSERT_EQ(static_cast<long double>(radius), exact) << code;
      ASSERT_GT(radius, before) << code;
      before = radius;
      ASSERT_EQ(encodeRadius(radius, unit), code);
      // Down to the code: anything up to the next code's radius keeps this one.
      const float next = code < kRadiusCodeMax ? decodeRadius(code + 1, unit) : 2.0f * unit;
      ASSERT_EQ(encodeRadius(std::nextafter(next, 0.0f), unit), code);
    }
    EXPECT_LT(before, 2.0f * unit);
  }
  EXPECT_EQ(decodeRadius(0, 1.0f), 0.0f);
}

RC_GTEST_PROP(SampleRadius, RoundsDownByLessThanAStepAndNeverToNothing, (uint32_t seed)) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> exponent(-14.9f, 0.999f);
  float before = 0.0f;
  uint32_t codeBefore = 0;
  std::vector<float> radii;
  for (int i = 0; i < 200; ++i) radii.push_back(std::exp2(exponent(random)));
  std::sort(radii.begin(), radii.end());
  for (const float radius : radii) {
    const uint32_t code = encodeRadius(radius, 1.0f);
    RC_ASSERT(code >= 1u);
    RC_ASSERT(code <= kRadiusCodeMax);
    RC_ASSERT((radius < before || code >= codeBefore));
    const float decoded = decodeRadius(code, 1.0f);
    RC_ASSERT(decoded <= radius);
    RC_ASSERT(decoded > radius * (1.0f - 1.0f / 64.0f));
    before = radius;
    codeBefore = code;
  }
}

TEST(SampleRadius, NeverZeroForASampleWhateverItsRadius) {
  for (const float radius : {0.0f, -0.0f, -1.0f, -kInfinity, kNan, 1e-45f, 1e-38f, 0x1p-16f, 0x1p-15f})
    EXPECT_EQ(encodeRadius(radius, 1.0f), 1u) << radius;
  for (const float radius : {2.0f, 3.0f, 1e10f, std::numeric_limits<float>::max(), kInfinity})
    EXPECT_EQ(encodeRadius(radius, 1.0f), kRadiusCodeMax) << radius;
  EXPECT_EQ(encodeRadius(1e30f, 0x1p-100f), kRadiusCodeMax);  // the quotient overflows
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
