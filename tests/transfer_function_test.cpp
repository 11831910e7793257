// Opacity correction down to steps of no length, repeated points as steps, ranges without extent, the baked table and its ends.
// Mirrors render/core/transfer_function.h; truth in long double.
#include "render/core/transfer_function.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace warpscope {
namespace {

constexpr double kMax = std::numeric_limits<double>::max();

long double correctedTruth(long double alpha, long double ds) {
  return alpha >= 1.0L ? (ds > 0.0L ? 1.0L : 0.0L) : -std::expm1(ds * std::log1p(-alpha));
}

TEST(OpacityCorrection, AgreesWithTheFormulaOverAllMagnitudes) {
  std::mt19937 random(41);
  std::uniform_real_distribution<float> exponent(-30.0f, 0.0f), stepExponent(-10.0f, 10.0f);
  for (int i = 0; i < 200000; ++i) {
    const float small = std::exp2(exponent(random));
    const float alpha = i % 2 ? small : 1.0f - small;
    const float ds = std::exp2(stepExponent(random));
    const long double truth = correctedTruth(alpha, ds);
    ASSERT_NEAR(correctOpacity(alpha, ds), static_cast<double>(truth), static_cast<double>(6e-7L * truth))
        << "seed 41: " << alpha << " over " << ds;
  }
}

TEST(OpacityCorrection, Ends) {
  for (const float ds : {1e-3f, 0.5f, 1.0f, 1e3f}) {
    EXPECT_EQ(correctOpacity(0.0f, ds), 0.0f);
    EXPECT_EQ(correctOpacity(1.0f, ds), 1.0f);
  }
  for (const float alpha : {0.0f, 1e-8f, 0.5f, 1.0f}) EXPECT_EQ(correctOpacity(alpha, 0.0f), 0.0f) << alpha;  // no step, no opacity
  EXPECT_NEAR(correctOpacity(1e-8f, 0.5f), 5e-9, 1e-15);  // does not vanish in rounding
}

RC_GTEST_PROP(OpacityCorrection, StaysInRangeAndRisesWithBoth, (uint32_t seed)) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> unit(0.0f, 1.0f);
  for (int i = 0; i < 100; ++i) {
    const float alpha = unit(random), ds = 4.0f * unit(random);
    const float corrected = correctOpacity(alpha, ds);
    RC_ASSERT(corrected >= 0.0f);
    RC_ASSERT(corrected <= 1.0f);
    RC_ASSERT(correctOpacity(alpha, ds * 1.01f) >= corrected);
    RC_ASSERT(correctOpacity(std::min(1.0f, alpha * 1.01f), ds) >= corrected);
  }
}

TransferFunction ramp() {
  return {{{10.0, {1.0f, 0.0f, 0.0f}, 0.0f}, {20.0, {0.0f, 1.0f, 0.0f}, 0.5f}, {40.0, {0.0f, 0.0f, 1.0f}, 1.0f}}};
}

TEST(TransferFunction, InterpolatesAndIsConstantBeyondItsEnds) {
  const TransferFunction function = ramp();
  EXPECT_EQ(function.at(-1e9), glm::vec4(1, 0, 0, 0));
  EXPECT_EQ(function.at(10.0), glm::vec4(1, 0, 0, 0));
  EXPECT_EQ(function.at(15.0), glm::vec4(0.5f, 0.5f, 0, 0.25f));
  EXPECT_EQ(function.at(20.0), glm::vec4(0, 1, 0, 0.5f));
  EXPECT_EQ(function.at(35.0), glm::vec4(0, 0.25f, 0.75f, 0.875f));
  EXPECT_EQ(function.at(40.0), glm::vec4(0, 0, 1, 1));
  EXPECT_EQ(function.at(1e300), glm::vec4(0, 0, 1, 1));
}

TEST(TransferFunction, InterpolatesBetweenTheWidestDoubles) {
  const TransferFunction function{{{-kMax, glm::vec3(0.0f), 0.0f}, {kMax, glm::vec3(1.0f), 1.0f}}};
  EXPECT_EQ(function.at(0.0), glm::vec4(0.5f));
  EXPECT_EQ(function.at(0.5 * kMax), glm::vec4(0.75f));
}

TEST(TransferFunction, RepeatedValuesAreAStep) {
  // Three corners at one place: from it on the last holds.
  const TransferFunction function{{{0.0, glm::vec3(0.0f), 0.0f},
                                   {5.0, glm::vec3(0.0f), 0.0f},
                                   {5.0, glm::vec3(0.5f), 0.9f},
                                   {5.0, glm::vec3(1.0f), 0.25f},
                                   {9.0, glm::vec3(1.0f), 0.25f}}};
  EXPECT_EQ(function.at(std::nextafter(5.0, 0.0)).a, 0.0f);
  EXPECT_EQ(function.at(5.0), glm::vec4(1.0f, 1.0f, 1.0f, 0.25f));
  EXPECT_EQ(function.at(std::nextafter(5.0, 9.0)).a, 0.25f);
  // A step at either end.
  const TransferFunction ends{{{1.0, glm::vec3(0.0f), 0.1f}, {1.0, glm::vec3(1.0f), 0.2f}}};
  EXPECT_EQ(ends.at(0.0).a, 0.1f);
  EXPECT_EQ(ends.at(1.0).a, 0.2f);
  EXPECT_EQ(ends.at(2.0).a, 0.2f);
}

TEST(TransferTable, EntriesAreThePremultipliedCorrectedFunction) {
  const TransferFunction function = ramp();
  for (const float step : {1.0f, 0.5f, 0.125f, 3.0f}) {
    const TransferTable table = bakeTransferTable(function, 0.0, 50.0, step);
    ASSERT_EQ(table.entries.size(), size_t{TransferTable::kSize});
    EXPECT_EQ(table.lower, 0.0);
    EXPECT_EQ(table.upper, 50.0);
    EXPECT_EQ(table.step, step);
    for (int i = 0; i < TransferTable::kSize; ++i) {
      const glm::vec4 straight = function.at(50.0 * i / (TransferTable::kSize - 1));
      const long double alpha = correctedTruth(straight.a, step);
      ASSERT_NEAR(table.entries[i].a, static_cast<double>(alpha), 1e-6) << i;
      for (int c = 0; c < 3; ++c) ASSERT_NEAR(table.entries[i][c], static_cast<double>(straight[c] * alpha), 1e-6) << i;
    }
  }
}

TEST(TransferTable, EndsBelongToTheFirstAndLastEntry) {
  // 16-bit data: the largest value hits the last entry, not one past it.
  const TransferFunction function{{{65534.0, glm::vec3(1.0f), 0.0f}, {65535.0, glm::vec3(1.0f), 1.0f}}};
  const TransferTable table = bakeTransferTable(function, 0.0, 65535.0, 1.0f);
  const float inverse = static_cast<float>(1.0 / 65535.0);
  EXPECT_EQ(transferIndex(65535.0f * inverse), TransferTable::kSize - 1);
  EXPECT_EQ(table.entries[transferIndex(65535.0f * inverse)].a, 1.0f);
  EXPECT_EQ(table.entries[transferIndex(0.0f)].a, 0.0f);
  EXPECT_EQ(transferIndex(1.0f), TransferTable::kSize - 1);
  EXPECT_EQ(transferIndex(1.0001f), TransferTable::kSize - 1);
  EXPECT_EQ(transferIndex(1e30f), TransferTable::kSize - 1);
  EXPECT_EQ(transferIndex(std::numeric_limits<float>::infinity()), TransferTable::kSize - 1);
  EXPECT_EQ(transferIndex(-1e30f), 0);
  EXPECT_EQ(transferIndex(std::nanf("")), 0);
}

TEST(TransferTable, ReadsTheNearestEntry) {
  for (int i = 0; i <= 100000; ++i) {
    const float unit = static_cast<float>(i) / 100000.0f;
    const long double place = static_cast<long double>(unit) * (TransferTable::kSize - 1);
    ASSERT_LE(std::abs(transferIndex(unit) - place), 0.5L + 3e-4L) << unit;
  }
}

TEST(TransferTable, StepsStaySteps) {
  // A step at 2000 of 0..4095: entry 1999 is before it, entry 2000 on it; nothing in between exists.
  const TransferFunction function{{{2000.0, glm::vec3(1.0f), 0.0f}, {2000.0, glm::vec3(1.0f), 1.0f}}};
  const TransferTable table = bakeTransferTable(function, 0.0, 4095.0, 0.5f);
  for (int i = 0; i < TransferTable::kSize; ++i) ASSERT_EQ(table.entries[i].a, i < 2000 ? 0.0f : 1.0f) << i;
}

TEST(TransferTable, RangeWithoutExtentIsItsOneValue) {
  const TransferFunction function{{{7.0, glm::vec3(1.0f), 0.0f}, {7.0, glm::vec3(1.0f), 0.75f}}};
  const TransferTable table = bakeTransferTable(function, 7.0, 7.0, 1.0f);
  for (const glm::vec4& entry : table.entries) ASSERT_FLOAT_EQ(entry.a, 0.75f);
  EXPECT_TRUE(table.anyVisible(0.0f, 0.0f));
}

TEST(TransferTable, RangeOfTheWidestDoubles) {
  // The extent overflows; the table must not. Only values above 0 are shown.
  const TransferFunction function{{{0.0, glm::vec3(1.0f), 0.0f}, {0.0, glm::vec3(1.0f), 0.5f}}};
  const TransferTable table = bakeTransferTable(function, -kMax, kMax, 1.0f);
  EXPECT_EQ(table.entries.front().a, 0.0f);
  EXPECT_FLOAT_EQ(table.entries.back().a, 0.5f);
  EXPECT_EQ(table.entries[2000].a, 0.0f);
  EXPECT_FLOAT_EQ(table.entries[2100].a, 0.5f);
}

TEST(TransferTable, AnyVisibleAgreesWithLookingAtEveryEntry) {
  std::mt19937 random(47);
  std::uniform_real_distribution<float> unit(-0.1f, 1.1f);
  for (int round = 0; round < 20; ++round) {
    // Islands of opacity, some a single entry wide.
    TransferFunction function;
    double value = 0.0;
    while (value < 1.0) {
      const float alpha = random() % 3 == 0 ? 0.01f : 0.0f;
      function.points.push_back({value, glm::vec3(1.0f), alpha});
      value += (random() % 4 == 0 ? 1.0 / 4095.0 : 0.08 * std::max(0.0f, unit(random))) + 1e-6;
      function.points.push_back({value, glm::vec3(1.0f), alpha});
    }
    const TransferTable table = bakeTransferTable(function, 0.0, 1.0, 0.5f);
    for (int i = 0; i < 500; ++i) {
      const float a = unit(random), b = i % 5 ? unit(random) : a;
      bool visible = false;
      for (int k = transferIndex(std::min(a, b)); k <= transferIndex(std::max(a, b)); ++k)
        visible = visible || table.entries[k].a > 0.0f;
      ASSERT_EQ(table.anyVisible(std::min(a, b), std::max(a, b)), visible) << "seed 47, round " << round;
    }
    EXPECT_FALSE(table.anyVisible(0.7f, 0.3f));
  }
}

}  // namespace
}  // namespace warpscope
