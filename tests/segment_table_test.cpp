// A step along which the value changes, by the table of both ends against the same step cut into many; and what is said to show nothing shows nothing.
// Mirrors render/core/segment_table.h.
#include "render/core/segment_table.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace warpscope {
namespace {

constexpr TransferDomain kDomain{0.0f, 1000.0f, false};

/// Ramps, plateaus and steps at random places.
TransferFunction randomFunction(std::mt19937& random, double lowest, double highest) {
  std::uniform_real_distribution<float> unit(0.0f, 1.0f);
  TransferFunction function;
  std::vector<double> values;
  for (int i = 0; i < 7; ++i) values.push_back(std::lerp(lowest, highest, static_cast<double>(unit(random))));
  values[3] = values[4];
  std::ranges::sort(values);
  for (const double value : values) function.points.push_back({value, {unit(random), unit(random), unit(random)}, unit(random) < 0.4f ? 0.0f : 0.9f * unit(random)});
  return function;
}

/// In double, of so many pieces of equal length.
glm::dvec4 composited(const TransferFunction& function, double front, double back, double step) {
  constexpr int kPieces = 20000;
  glm::dvec3 color(0.0);
  double through = 1.0;
  for (int i = 0; i < kPieces; ++i) {
    const glm::dvec4 straight(function.at(std::lerp(front, back, (i + 0.5) / kPieces)));
    const double left = std::pow(1.0 - straight.a, step / kPieces);
    color += through * (1.0 - left) * glm::dvec3(straight);
    through *= left;
  }
  return {color, 1.0 - through};
}

glm::vec4 lookedUp(const SegmentLookup& table, float front, float back) {
  const SegmentPlace place = segmentPlace(table, table.placeOf(front), table.placeOf(back));
  return {colorOf(table, place), alphaOf(table, table.alphas, place)};
}

TEST(SegmentTable, AStepIsWhatItIsMadeOf) {
  std::mt19937 random(11);
  for (int round = 0; round < 12; ++round) {
    const TransferFunction function = randomFunction(random, 100.0, 700.0);
    const float step = round % 2 == 0 ? 1.0f : 2.5f;
    const SegmentTable table = bakeSegmentTable(function, kDomain, step);
    const SegmentLookup lookup = table.lookup();
    std::uniform_real_distribution<double> value(0.0, 1000.0);
    for (int i = 0; i < 60; ++i) {
      const double front = value(random), back = value(random);
      if (std::abs(back - front) < 20.0) continue;  // of steps that are no wider than some nodes: below
      const glm::dvec4 expected = composited(function, front, back, step);
      const glm::vec4 found = lookedUp(lookup, static_cast<float>(front), static_cast<float>(back));
      for (int channel = 0; channel < 4; ++channel) EXPECT_NEAR(found[channel], expected[channel], 0.02) << front << " to " << back;
    }
  }
}

TEST(SegmentTable, AtNodesOpacityIsExactAndColourAsGoodAsItsPieces) {
  std::mt19937 random(5);
  for (int round = 0; round < 8; ++round) {
    TransferFunction function = randomFunction(random, 0.0, 200.0);
    function.points.front().value = 0.0;  // it changes everywhere: every whole number is a node
    function.points.back().value = 200.0;
    const SegmentTable table = bakeSegmentTable(function, {0.0f, 200.0f, true}, 1.5f);
    ASSERT_EQ(table.nodes, 201);
    const SegmentLookup lookup = table.lookup();
    std::uniform_int_distribution<int> value(0, 200);
    for (int i = 0; i < 60; ++i) {
      const int front = value(random), back = value(random);
      if (front == back) continue;
      const glm::dvec4 expected = composited(function, front, back, 1.5);
      const glm::vec4 found = lookedUp(lookup, static_cast<float>(front), static_cast<float>(back));
      EXPECT_NEAR(found.a, expected.a, 1e-4) << front << " to " << back;
      for (int channel = 0; channel < 3; ++channel) EXPECT_NEAR(found[channel], expected[channel], 4e-3);
    }
  }
}

TEST(SegmentTable, AValueThatStaysIsClassifiedAsItIs) {
  std::mt19937 random(3);
  const TransferFunction function = randomFunction(random, 0.0, 255.0);
  const SegmentTable table = bakeSegmentTable(function, {0.0f, 255.0f, true}, 0.5f);
  for (int value = 0; value <= 255; ++value) {
    const glm::vec4 straight = function.at(value), found = lookedUp(table.lookup(), static_cast<float>(value), static_cast<float>(value));
    const float alpha = correctOpacity(straight.a, 0.5f);
    EXPECT_NEAR(found.a, alpha, 1e-6f) << value;
    for (int channel = 0; channel < 3; ++channel) EXPECT_NEAR(found[channel], straight[channel] * alpha, 1e-6f) << value;
  }
}

TEST(SegmentTable, TheWayBackHoldsBackAsMuch) {
  std::mt19937 random(7);
  const SegmentTable table = bakeSegmentTable(randomFunction(random, 200.0, 800.0), kDomain, 1.0f);
  for (int a = 0; a < table.nodes; ++a)
    for (int b = 0; b < a; ++b)
      ASSERT_EQ(table.alphas[static_cast<size_t>(a * table.nodes + b)], table.alphas[static_cast<size_t>(b * table.nodes + a)]);
}

TEST(SegmentTable, OpaqueStaysOpaqueAndNothingStaysNothing) {
  const TransferFunction function{{{300.0, glm::vec3(1.0f), 0.0f}, {300.0, {0.2f, 0.4f, 0.6f}, 1.0f}}};
  for (const float step : {0.001f, 0.5f, 4.0f}) {
    const SegmentTable table = bakeSegmentTable(function, kDomain, step);
    const SegmentLookup lookup = table.lookup();
    EXPECT_EQ(lookedUp(lookup, 0.0f, 290.0f).a, 0.0f);
    EXPECT_EQ(lookedUp(lookup, 310.0f, 1000.0f).a, 1.0f);
    EXPECT_EQ(lookedUp(lookup, 290.0f, 320.0f).a, 1.0f) << step;
    EXPECT_NEAR(lookedUp(lookup, 900.0f, 310.0f).b, 0.6f, 1e-6f);
  }
}

/// Of ranges of values that show nothing by the bins, no step shows anything: leaping over cells leaves no opacity out.
TEST(SegmentTable, WhatIsSaidToShowNothingShowsNothing) {
  std::mt19937 random(19);
  int hidden = 0;
  for (const TransferDomain domain : {kDomain, TransferDomain{0.0f, 255.0f, true}, TransferDomain{-3e4f, 3e4f, true}, TransferDomain{-1e-3f, 2e-3f, false}}) {
    const double lowest = domain.lower, highest = domain.upper;
    std::uniform_real_distribution<float> value(domain.lower, domain.upper);
    for (int round = 0; round < 20; ++round) {
      const double part = round % 3 == 0 ? 0.001 : 0.4;
      const TransferFunction function = randomFunction(random, std::lerp(lowest, highest, 0.3), std::lerp(lowest, highest, 0.3 + part));
      const SegmentTable table = bakeSegmentTable(function, domain, 1.0f);
      const TransferTable bins = visibleBySegments(table);
      for (int i = 0; i < 400; ++i) {
        const float a = value(random), b = i % 2 == 0 ? value(random) : std::clamp(a + 0.002f * (domain.upper - domain.lower), domain.lower, domain.upper);
        if (bins.anyVisible(std::min(a, b), std::max(a, b))) continue;
        ++hidden;
        for (const auto& [front, back] : {std::pair(a, b), std::pair(b, a), std::pair(a, a), std::pair(std::midpoint(a, b), b)})
          ASSERT_EQ(lookedUp(table.lookup(), front, back).a, 0.0f) << front << " to " << back;
      }
      EXPECT_TRUE(bins.anyVisible(domain.lower, domain.upper) || table.mostOpacity == 0.0f);
    }
  }
  EXPECT_GT(hidden, 1000);
}

}  // namespace
}  // namespace warpscope
