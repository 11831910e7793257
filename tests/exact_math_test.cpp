// Logarithm and exponential against 100 digits, over all that opacities can be. Opacity correction: stability/marching_test.cpp.
// Mirrors render/core/exact_math.h.
#include "render/core/exact_math.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <boost/multiprecision/cpp_bin_float.hpp>
#include <cmath>
#include <limits>
#include <random>

#include "tests/opacities.h"

namespace warpscope {
namespace {

using Exact = boost::multiprecision::cpp_bin_float_100;

constexpr uint32_t kSeed = 30;

double relativeError(double value, const Exact& truth) {
  return static_cast<double>(abs((Exact(value) - truth) / truth));
}

TEST(ExactMath, LogarithmIsWithinItsErrorOfTheTruth) {
  std::mt19937 random(kSeed);
  double worst = 0.0;
  for (const float alpha : opacities(4000, random)) {
    const double error = relativeError(logOfOneMinus(alpha), log1p(-Exact(alpha)));
    ASSERT_LE(error, kExactMathError) << "seed " << kSeed << ": " << alpha;
    worst = std::max(worst, error);
  }
  EXPECT_GT(worst, 0.0);
  EXPECT_EQ(logOfOneMinus(0.0f), 0.0);
}

TEST(ExactMath, ExponentialIsWithinItsErrorOfTheTruth) {
  std::mt19937 random(kSeed + 1);
  std::uniform_real_distribution<double> exponent(-300.0, 14.0);
  for (int i = 0; i < 12000; ++i) {
    // Every magnitude; around each border between two turns; beyond the last bit.
    const double y = i % 3 == 0   ? -std::exp2(exponent(random))
                     : i % 3 == 1 ? -kLn2 * (0.5 + i % 60) * (1.0 + 1e-15 * (i % 7 - 3))
                                  : -50.0 * std::generate_canonical<double, 53>(random);
    ASSERT_LE(relativeError(oneMinusExp(y), -expm1(Exact(y))), kExactMathError) << "seed " << kSeed + 1 << ": " << y;
  }
  EXPECT_EQ(oneMinusExp(0.0), 0.0);
  EXPECT_EQ(oneMinusExp(-std::numeric_limits<double>::infinity()), 1.0);
}

}  // namespace
}  // namespace warpscope
