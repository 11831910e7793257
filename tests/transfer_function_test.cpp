// Opacity correction's ends, repeated points as steps. Opacities of all magnitudes: stability/marching_test.cpp.
// The table that is baked: stability/transfer_table_test.cpp.
// Mirrors render/core/transfer_function.h.
#include "render/core/transfer_function.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace warpscope {
namespace {

constexpr double kMax = std::numeric_limits<double>::max();

TEST(OpacityCorrection, Ends) {
  for (const float ds : {1e-3f, 0.5f, 1.0f, 1e3f}) {
    EXPECT_EQ(correctOpacity(0.0f, ds), 0.0f);
    EXPECT_EQ(correctOpacity(1.0f, ds), 1.0f);
  }
  for (const float alpha : {0.0f, 1e-8f, 0.5f, 1.0f}) EXPECT_EQ(correctOpacity(alpha, 0.0f), 0.0f) << alpha;  // no step, no opacity
  EXPECT_NEAR(correctOpacity(1e-8f, 0.5f), 5e-9, 1e-15);  // does not vanish in rounding
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
  EXPECT_EQ(function.below(5.0), glm::vec4(0.0f));
  EXPECT_EQ(function.below(std::nextafter(5.0, 9.0)), function.at(std::nextafter(5.0, 9.0)));
  EXPECT_EQ(function.at(5.0), glm::vec4(1.0f, 1.0f, 1.0f, 0.25f));
  EXPECT_EQ(function.at(std::nextafter(5.0, 9.0)).a, 0.25f);
  // A step at either end.
  const TransferFunction ends{{{1.0, glm::vec3(0.0f), 0.1f}, {1.0, glm::vec3(1.0f), 0.2f}}};
  EXPECT_EQ(ends.at(0.0).a, 0.1f);
  EXPECT_EQ(ends.below(1.0).a, 0.1f);
  EXPECT_EQ(ends.at(1.0).a, 0.2f);
  EXPECT_EQ(ends.at(2.0).a, 0.2f);
}

}  // namespace
}  // namespace warpscope
