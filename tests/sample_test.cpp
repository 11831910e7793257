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

/// Bounds as they occur: symmetric about 0, of any size; and a few that are not.
std::vector<std::pair<float, float>> someBounds() {
  return {{-0.5f, 0.5f}, {-64.0f, 64.0f}, {-88.0f, 88.0f}, {-3e4f, 3e4f}, {-3e10f, 3e10f}, {-1e-6f, 1e-6f},
          {0.0f, 1.0f},  {0.1f, 0.7f},    {-10.0f, -3.0f}, {100.0f, 117.3f}};
}

/// Rounding of the floats themselves, a few units in the last place of the larger bound.
long double rounding(float lower, float upper) {
  return 4.0L * 0x1p-24L * std::max(std::abs(static_cast<long double>(lower)), std::abs(static_cast<long double>(upper)));
}

TEST(SamplePosition, EndsAreExact) {
  for (const auto& [lower, upper] : someBounds()) {
    EXPECT_EQ(quantizeCoordinate(lower, lower, upper), 0u);
    EXPECT_EQ(quantizeCoordinate(upper, lower, upper), kPositionMax);
    EXPECT_EQ(dequantizeCoordinate(0, lower, upper), lower);
    EXPECT_EQ(dequantizeCoordinate(kPositionMax, lower, upper), upper);
  }
}

RC_GTEST_PROP(SamplePosition, AtMostHalfAStepOff, (uint32_t seed)) {
  // The quotient's rounding, two units in the last place of 2^18 steps, may decide ties otherwise.
  constexpr long double kFloatShare = 2.0L * 0x1p-24L * kPositionMax;
  std::mt19937 random(seed);
  for (const auto& [lower, upper] : someBounds()) {
    const long double step = (static_cast<long double>(upper) - lower) / kPositionMax;
    std::uniform_real_distribution<float> inside(lower, upper);
    for (int i = 0; i < 300; ++i) {
      const float value = std::min(inside(random), upper);
      const float back = dequantizeCoordinate(quantizeCoordinate(value, lower, upper), lower, upper);
      RC_ASSERT(std::abs(static_cast<long double>(back) - value) <= 0.5L * step + rounding(lower, upper) + kFloatShare * step);
    }
  }
}

TEST(SamplePosition, EveryCodeComesBack) {
  for (const auto& [lower, upper] : {std::pair{-64.0f, 64.0f}, {-0.5f, 0.5f}, {-90.5f, 90.5f}, {0.0f, 1.0f}}) {
    float before = -kInfinity;
    for (uint32_t code = 0; code <= kPositionMax; ++code) {
      const float value = dequantizeCoordinate(code, lower, upper);
      ASSERT_EQ(quantizeCoordinate(value, lower, upper), code) << lower << " " << upper;
      ASSERT_GT(value, before) << code;
      before = value;
      const long double exact = lower + (static_cast<long double>(upper) - lower) * code / kPositionMax;
      ASSERT_NEAR(static_cast<double>(value - exact), 0.0, static_cast<double>(rounding(lower, upper))) << code;
    }
  }
}

TEST(SamplePosition, OutsideIsClampedAndNanIsTheLowerBound) {
  EXPECT_EQ(quantizeCoordinate(-1.001f, -1.0f, 1.0f), 0u);
  EXPECT_EQ(quantizeCoordinate(1.001f, -1.0f, 1.0f), kPositionMax);
  EXPECT_EQ(quantizeCoordinate(-kInfinity, -1.0f, 1.0f), 0u);
  EXPECT_EQ(quantizeCoordinate(kInfinity, -1.0f, 1.0f), kPositionMax);
  EXPECT_EQ(quantizeCoordinate(3e38f, -1.0f, 1.0f), kPositionMax);
  EXPECT_EQ(quantizeCoordinate(kNan, -1.0f, 1.0f), 0u);
}

TEST(SamplePosition, AxisWithoutExtent) {
  for (const float place : {0.0f, -2.5f, 1e7f}) {
    EXPECT_EQ(quantizeCoordinate(place, place, place), 0u);
    EXPECT_EQ(dequantizeCoordinate(0, place, place), place);
  }
  const SampleQuantization flat{{{-4.0f, 2.0f, -8.0f}, {4.0f, 2.0f, 8.0f}}, 1.0f};
  const Sphere sphere = unpackSample(packSample({1.0f, 2.0f, -8.0f}, 0.5f, flat), flat);
  EXPECT_NEAR(sphere.center.x, 1.0f, 8.0f / kPositionMax);
  EXPECT_EQ(sphere.center.y, 2.0f);
  EXPECT_EQ(sphere.center.z, -8.0f);
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
  const SampleQuantization q{{glm::vec3(0.0f), glm::vec3(static_cast<float>(kPositionMax))}, 1.0f};
  const PackedSample sample = packSample({1.0f, 2.0f, 3.0f}, 1.5f, q);
  EXPECT_EQ(sample & kPositionMax, 1u);
  EXPECT_EQ(sample >> 18 & kPositionMax, 2u);
  EXPECT_EQ(sample >> 36 & kPositionMax, 3u);
  EXPECT_EQ(sample >> 54, 15u << 6 | 32u);
  EXPECT_EQ(radiusCode(sample), 15u << 6 | 32u);
  const PackedSample all = packSample(q.bounds.upper, 1e9f, q);
  EXPECT_EQ(all, ~PackedSample{0});
  EXPECT_EQ(unpackSample(all, q).center, q.bounds.upper);
  EXPECT_EQ(radiusCode(packSample({kNan, kNan, kNan}, kNan, q)), 1u);
}

RC_GTEST_PROP(PackedSample, UnpackingIsTheInverseOfPacking, (uint32_t seed)) {
  std::mt19937_64 random(seed);
  const SampleQuantization q{{{-88.0f, -64.0f, -3.5f}, {88.0f, 64.0f, 3.5f}}, 2.0f};
  for (int i = 0; i < 100; ++i) {
    PackedSample sample = random();
    if (radiusCode(sample) == 0) continue;
    const Sphere sphere = unpackSample(sample, q);
    RC_ASSERT(packSample(sphere.center, sphere.radius, q) == sample);
  }
}

}  // namespace
}  // namespace warpscope
