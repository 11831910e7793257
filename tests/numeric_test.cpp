// Multiplication and addition in one rounding, by instruction, by plain operations and in vectors; in two where not asked.
// Mirrors render/core/numeric.h, simd.h and opacity_batch.h; truth in so many bits that every result here is exact.
#include "render/core/numeric.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <boost/multiprecision/cpp_bin_float.hpp>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "render/core/opacity_batch.h"
#include "render/core/simd.h"

namespace warpscope {
namespace {

using Exact =
    boost::multiprecision::number<boost::multiprecision::cpp_bin_float<700, boost::multiprecision::digit_base_2>>;

constexpr uint32_t kSeed = 53;
constexpr int kRounds = 40000;

struct Operands {
  float a, b, c;
};

float floatOf(std::mt19937::result_type bits) { return std::bit_cast<float>(static_cast<uint32_t>(bits)); }

/// Of any magnitude; half of them such that the product's rounding decides, or that the sum lies at the middle between
/// two floats.
Operands randomOperands(std::mt19937& random) {
  const auto anyFloat = [&] { return floatOf((random() & 0x807fffffu) | (1 + random() % 253) << 23); };
  const auto ordinary = [&] { return floatOf((random() & 0x807fffffu) | (117 + random() % 20) << 23); };
  switch (random() % 4) {
    case 0:
      return {anyFloat(), anyFloat(), anyFloat()};
    case 1:
      return {ordinary(), ordinary(), ordinary()};
    case 2: {  // nearly the product's opposite
      const float a = ordinary(), b = ordinary();
      return {a, b, -(a * b)};
    }
    default: {  // a sum at, or a little beside, the middle between two floats
      const float c = floatOf(0x3f800000u | (random() & 0x7fffffu));
      const float beside = random() % 2 ? 1.0f : 1.0f + std::numeric_limits<float>::epsilon();
      return {beside, random() % 2 ? 0x1p-24f : -0x1p-24f, c};
    }
  }
}

float truthOf(const Operands& in) { return static_cast<float>(Exact(in.a) * Exact(in.b) + Exact(in.c)); }

bool isSame(float a, float b) { return a == b || (std::isnan(a) && std::isnan(b)); }

TEST(MulAdd, RoundsOnce) {
  std::mt19937 random(kSeed);
  for (int i = 0; i < kRounds; ++i) {
    const Operands in = randomOperands(random);
    const float fused = mulAdd(in.a, in.b, in.c);
    ASSERT_TRUE(isSame(mulAddInDouble(in.a, in.b, in.c), fused))
        << "seed " << kSeed << ", " << i << ": " << in.a << " " << in.b << " " << in.c;
    if (!std::isnormal(fused) && fused != 0.0f)
      continue;  // Exact's conversion knows neither the smallest nor infinity as float does
    ASSERT_EQ(fused, truthOf(in)) << "seed " << kSeed << ", " << i << ": " << in.a << " " << in.b << " " << in.c;
  }
}

TEST(MulAdd, WhatIsNotFiniteStaysSo) {
  const float infinity = std::numeric_limits<float>::infinity(), largest = std::numeric_limits<float>::max();
  for (const Operands& in : {Operands{largest, 2.0f, 0.0f},
                             {largest, 2.0f, -largest},
                             {infinity, 1.0f, -largest},
                             {infinity, 0.0f, 1.0f},
                             {infinity, 1.0f, -infinity},
                             {std::nanf(""), 1.0f, 1.0f},
                             {1.0f, 1.0f, std::nanf("")},
                             {0x1p-100f, 0x1p-49f, 0.0f},
                             {0x1p-100f, 0x1p-49f, 0x1p-149f},
                             {0x1p-75f, 0x1p-75f, 0x1p-149f},
                             {-0x1p-75f, 0x1p-75f, 0x1p-148f}})
    EXPECT_TRUE(isSame(mulAddInDouble(in.a, in.b, in.c), std::fma(in.a, in.b, in.c)))
        << in.a << " " << in.b << " " << in.c;
}

TEST(MulAdd, VectorsRoundAsSingleNumbersDo) {
  std::mt19937 random(kSeed + 1);
  for (int i = 0; i < kRounds / kBatchLanes; ++i) {
    alignas(64) float a[kBatchLanes], b[kBatchLanes], c[kBatchLanes], out[kBatchLanes];
    for (int k = 0; k < kBatchLanes; ++k) {
      const Operands in = randomOperands(random);
      a[k] = in.a;
      b[k] = in.b;
      c[k] = in.c;
    }
    mulAdd(FloatBatch::load_aligned(a), FloatBatch::load_aligned(b), FloatBatch::load_aligned(c)).store_aligned(out);
    for (int k = 0; k < kBatchLanes; ++k)
      ASSERT_TRUE(isSame(out[k], mulAdd(a[k], b[k], c[k]))) << "seed " << kSeed + 1 << ", " << i;
  }
}

TEST(FloatingPoint, NothingIsFusedUnasked) {
  // Read anew each time, so that the compiler knows neither the result nor that it has the product already.
  volatile float factor = 1.0f + 0x1p-12f;
  volatile float rounded = factor * factor;
  EXPECT_EQ(factor * factor - rounded, 0.0f);
  volatile double doubleFactor = 1.0 + 0x1p-30;
  volatile double doubleRounded = doubleFactor * doubleFactor;
  EXPECT_EQ(doubleFactor * doubleFactor - doubleRounded, 0.0);
  // Neither product is exact.
  EXPECT_NE(mulAdd(float{factor}, float{factor}, -float{rounded}), 0.0f);
  EXPECT_NE(mulAdd(double{doubleFactor}, double{doubleFactor}, -double{doubleRounded}), 0.0);
}

TEST(OpacityBatch, EachIsThatOfOneAlone) {
  std::vector<float> depths{0.0f, -0.0f, -1.0f, 1e-45f, 1e-38f, 80.0f, std::nextafter(80.0f, 0.0f), std::nextafter(80.0f, 100.0f), 1e30f, -1e30f, INFINITY, -INFINITY, NAN};
  for (float depth = 1e-12f; depth < 200.0f; depth *= 1.0007f) depths.push_back(depth);
  depths.resize((depths.size() + kBatchLanes - 1) / kBatchLanes * kBatchLanes, 0.5f);
  alignas(64) float given[kBatchLanes], found[kBatchLanes];
  for (size_t i = 0; i < depths.size(); i += kBatchLanes) {
    std::copy_n(depths.begin() + static_cast<std::ptrdiff_t>(i), kBatchLanes, given);
    opacityOf(FloatBatch::load_aligned(given)).store_aligned(found);
    for (int lane = 0; lane < kBatchLanes; ++lane) ASSERT_EQ(bitsOf(found[lane]), bitsOf(opacityOf(given[lane]))) << given[lane];
  }
}

}  // namespace
}  // namespace warpscope
