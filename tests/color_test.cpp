// Colour encodings against the standard's formula in higher precision, and against each other.
// Mirrors render/core/color.h; IEC 61966-2-1.
#include "render/core/color.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace warpscope {
namespace {

long double srgbTruth(long double linear) {
  return linear <= 0.0031308L ? 12.92L * linear : 1.055L * std::pow(linear, 1.0L / 2.4L) - 0.055L;
}
long double linearTruth(long double encoded) {
  return encoded <= 0.04045L ? encoded / 12.92L : std::pow((encoded + 0.055L) / 1.055L, 2.4L);
}

Rgba8 pack(uint32_t r, uint32_t g, uint32_t b, uint32_t a) { return r | g << 8 | b << 16 | a << 24; }

TEST(Srgb, AgreesWithTheFormula) {
  for (int i = 0; i <= 20000; ++i) {
    const float value = static_cast<float>(i) / 20000.0f;
    ASSERT_NEAR(srgbFromLinear(value), static_cast<double>(srgbTruth(value)), 4e-7) << value;
    ASSERT_NEAR(linearFromSrgb(value), static_cast<double>(linearTruth(value)), 4e-7) << value;
  }
  EXPECT_EQ(srgbFromLinear(0.0f), 0.0f);
  EXPECT_NEAR(srgbFromLinear(0.5f), 0.735356983, 1e-6);  // known value
}

TEST(Unorm8, RoundsToNearestAndClamps) {
  for (int i = 0; i < 100000; ++i) {
    const float value = static_cast<float>(i) / 99999.0f;
    const long double exact = static_cast<long double>(value) * 255.0L;
    ASSERT_LE(std::abs(quantizeUnorm8(value) - exact), 0.5L + 2e-5L) << value;
  }
  const float inf = std::numeric_limits<float>::infinity();
  EXPECT_EQ(quantizeUnorm8(-1.0f), 0u);
  EXPECT_EQ(quantizeUnorm8(-inf), 0u);
  EXPECT_EQ(quantizeUnorm8(7.0f), 255u);
  EXPECT_EQ(quantizeUnorm8(inf), 255u);
  EXPECT_EQ(quantizeUnorm8(std::nanf("")), 0u);
}

TEST(Rgba8, EveryChannelComesBackWithEveryAlpha) {
  const ColorTables& tables = ColorTables::instance();
  for (uint32_t alpha = 1; alpha < 256; ++alpha)
    for (uint32_t channel = 0; channel < 256; ++channel) {
      const Rgba8 code = pack(channel, 255 - channel, channel ^ 0x55, alpha);
      ASSERT_EQ(tables.encode(tables.decode(code)), code);
    }
}

TEST(Rgba8, DecodesToPremultipliedLinear) {
  for (uint32_t alpha = 0; alpha < 256; alpha += 5)
    for (uint32_t channel = 0; channel < 256; ++channel) {
      const glm::vec4 color = decodeRgba8(pack(channel, 0, 255, alpha));
      ASSERT_NEAR(color.a, alpha / 255.0, 1e-7);
      ASSERT_NEAR(color.r, static_cast<double>(linearTruth(channel / 255.0L) * alpha / 255.0L), 4e-7);
      ASSERT_EQ(color.g, 0.0f);
      ASSERT_NEAR(color.b, alpha / 255.0, 1e-7);
      ASSERT_EQ(ColorTables::instance().decode(pack(channel, 0, 255, alpha)), color);  // bit for bit
    }
}

TEST(Rgba8, NothingStaysNothingAndFaintKeepsItsColour) {
  const ColorTables& tables = ColorTables::instance();
  EXPECT_EQ(tables.encode(glm::vec4(0.0f)), 0u);
  EXPECT_EQ(tables.encode({1.0f, 1.0f, 1.0f, std::nanf("")}), 0u);
  EXPECT_EQ(tables.encode({1.0f, 1.0f, 1.0f, -1.0f}), 0u);
  EXPECT_EQ(tables.encode(1e-4f * glm::vec4(1.0f, 0.0f, 1.0f, 1.0f)), pack(255, 0, 255, 0));
  // Brighter than white: clamped, not wrapped.
  EXPECT_EQ(tables.encode({9.0f, 0.5f, 0.0f, 0.5f}), pack(255, 255, 0, 128));
}

/// Rounded code of the exact curve, and whether the value is so near a boundary between codes that both answers are right.
uint32_t exactCode(float linear, bool& undecided) {
  const long double scaled = 255.0L * srgbTruth(std::min(1.0L, std::max(0.0L, static_cast<long double>(linear))));
  undecided = std::abs(scaled - std::floor(scaled) - 0.5L) < 1e-4L;
  return static_cast<uint32_t>(scaled + 0.5L);
}

RC_GTEST_PROP(ColorTables, EncodingIsTheFormula, (uint32_t seed)) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> unit(0.0f, 1.0f), exponent(-12.0f, 0.0f);
  for (int i = 0; i < 1000; ++i) {
    const float value = i % 2 ? unit(random) : std::exp2(exponent(random));
    bool undecided = false;
    const uint32_t exact = exactCode(value, undecided);
    const uint32_t table = ColorTables::instance().encodeChannel(value);
    RC_ASSERT((undecided ? std::abs(int(table) - int(exact)) <= 1 : table == exact));
    if (!undecided) RC_ASSERT(quantizeUnorm8(srgbFromLinear(value)) == exact);
  }
}

TEST(ColorTables, CodesChangeWhereTheFormulaSays) {
  for (int code = 0; code < 255; ++code) {
    const auto boundary = static_cast<float>(linearTruth((code + 0.5L) / 255.0L));
    EXPECT_EQ(ColorTables::instance().encodeChannel(boundary * (1.0f - 1e-5f)), static_cast<uint32_t>(code));
    EXPECT_EQ(ColorTables::instance().encodeChannel(boundary * (1.0f + 1e-5f)), static_cast<uint32_t>(code) + 1);
  }
  const ColorTables& tables = ColorTables::instance();
  EXPECT_EQ(tables.encodeChannel(std::nextafter(1.0f, 0.0f)), 255u);
  EXPECT_EQ(tables.encodeChannel(2.0f), 255u);
  EXPECT_EQ(tables.encodeChannel(-1.0f), 0u);
  EXPECT_EQ(tables.encodeChannel(std::nanf("")), 0u);
}

RC_GTEST_PROP(Over, IsPorterDuff, (uint32_t seed)) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> unit(0.0f, 1.0f);
  const auto color = [&] {
    const float alpha = unit(random);
    return glm::vec4(alpha * unit(random), alpha * unit(random), alpha * unit(random), alpha);
  };
  const glm::vec4 a = color(), b = color(), c = color();
  for (int i = 0; i < 4; ++i)
    RC_ASSERT(std::abs(over(a, b)[i] - (static_cast<double>(a[i]) + (1.0 - a.a) * b[i])) < 2e-7);
  const glm::vec4 difference = over(over(a, b), c) - over(a, over(b, c));
  for (int i = 0; i < 4; ++i) RC_ASSERT(std::abs(difference[i]) < 5e-7f);
  RC_ASSERT(over(a, glm::vec4(0.0f)) == a);
  RC_ASSERT(over(glm::vec4(0.0f), a) == a);
  const glm::vec4 opaque(unit(random), unit(random), unit(random), 1.0f);
  RC_ASSERT(over(opaque, a) == opaque);
}

}  // namespace
}  // namespace warpscope
