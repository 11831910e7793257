// PSNR against values worked out by hand. Identical images, NaN pixels, sums in long double: stability/metrics_test.cpp.
// Mirrors render/metrics/psnr.h.
#include "render/metrics/psnr.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <limits>

#include "render/base/error.h"
#include "tests/metric_pictures.h"

namespace warpscope {
namespace {

const glm::vec3 kBlack(0.0f);

/// A linear grey that the sRGB curve shows as `encoded`.
glm::vec4 shownAs(double encoded) {
  const double linear = encoded <= 0.04045 ? encoded / 12.92 : std::pow((encoded + 0.055) / 1.055, 2.4);
  return glm::vec4(glm::vec3(static_cast<float>(linear)), 1.0f);
}

TEST(Psnr, KnownValues) {
  // Everywhere 0.1 apart: MSE 0.01, 20 dB. In one of four pixels: 6.02 dB more. In one channel of that: 4.77 dB more.
  Image<glm::vec4> reference(2, 2, shownAs(0.5)), image(2, 2, shownAs(0.6));
  EXPECT_NEAR(psnrSrgb(image, reference, kBlack), 20.0, 1e-4);
  image = reference;
  image(1, 0) = shownAs(0.4);
  EXPECT_NEAR(psnrSrgb(image, reference, kBlack), 20.0 + 10.0 * std::log10(4.0), 1e-4);
  image(1, 0).g = image(1, 0).b = reference(1, 0).r;
  EXPECT_NEAR(psnrSrgb(image, reference, kBlack), 20.0 + 10.0 * std::log10(12.0), 1e-4);
  EXPECT_NEAR(psnrSrgb({1, 1, glm::vec4(1.0f)}, {1, 1, glm::vec4(0, 0, 0, 1)}, kBlack), 0.0, 1e-6);  // white against black
}

TEST(Psnr, TransparentPixelsShowTheBackground) {
  const glm::vec3 grey(shownAs(0.25));
  const Image<glm::vec4> clear(3, 3, glm::vec4(0.0f));
  EXPECT_NEAR(psnrSrgb({3, 3, glm::vec4(grey, 1.0f)}, clear, kBlack), -20.0 * std::log10(0.25), 1e-4);
  EXPECT_GT(psnrSrgb({3, 3, glm::vec4(grey, 1.0f)}, clear, grey), 120.0);  // the same picture, made in another way
  // Half-transparent white over black and grey of that brightness.
  EXPECT_GT(psnrSrgb({3, 3, glm::vec4(0.5f)}, {3, 3, glm::vec4(0.5f, 0.5f, 0.5f, 1.0f)}, kBlack), 120.0);
}

TEST(Psnr, BrighterThanWhiteShowsAsWhite) {
  EXPECT_EQ(psnrSrgb({2, 2, glm::vec4(3, 3, 3, 1)}, {2, 2, glm::vec4(1.0f)}, kBlack), std::numeric_limits<double>::infinity());
}

TEST(Psnr, TheSameWhateverTheNumberOfThreads) {
  const Image<glm::vec4> image = noise(500, 300, 1), reference = noise(500, 300, 2);
  const double parallel = psnrSrgb(image, reference, kBlack);
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  EXPECT_EQ(psnrSrgb(image, reference, kBlack), parallel);
}

TEST(Psnr, RefusesWhatHasNoAnswer) {
  EXPECT_THROW(psnrSrgb({2, 3}, {3, 2}, kBlack), InputError);
  EXPECT_THROW(psnrSrgb({}, {}, kBlack), InputError);
}

}  // namespace
}  // namespace warpscope
