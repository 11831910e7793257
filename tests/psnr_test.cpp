// PSNR of identical images and of NaN pixels, and against values worked out by hand and a sum in long double.
// Mirrors render/metrics/psnr.h.
#include "render/metrics/psnr.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <limits>
#include <random>

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

TEST(Psnr, IdenticalImagesAreInfinite) {
  for (const auto& [width, height] : {std::pair<uint32_t, uint32_t>{1, 1}, {17, 3}, {301, 203}}) {
    const Image<glm::vec4> image = noise(width, height, 56);
    EXPECT_EQ(psnrSrgb(image, image, kBlack), std::numeric_limits<double>::infinity());
  }
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

RC_GTEST_PROP(Psnr, AgreesWithANaiveSum, (uint32_t seed)) {
  std::mt19937 random(seed);
  const uint32_t width = 1 + random() % 40, height = 1 + random() % 40;
  const Image<glm::vec4> image = noise(width, height, random()), reference = noise(width, height, random());
  const glm::vec3 background(0.1f, 0.2f, 0.3f);
  const auto shown = [&](const glm::vec4& p, int c) {
    const long double linear = std::min(1.0L, p[c] + (1.0L - p.a) * background[c]);
    return linear <= 0.0031308L ? 12.92L * linear : 1.055L * std::pow(linear, 1.0L / 2.4L) - 0.055L;
  };
  long double sum = 0.0L;
  for (size_t i = 0; i < image.size(); ++i)
    for (int c = 0; c < 3; ++c) sum += std::pow(shown(image[i], c) - shown(reference[i], c), 2.0L);
  const long double truth = -10.0L * std::log10(sum / (3.0L * image.size()));
  const double psnr = psnrSrgb(image, reference, background);
  RC_ASSERT(std::abs(psnr - static_cast<double>(truth)) < 1e-4);
  RC_ASSERT(psnr == psnrSrgb(reference, image, background));
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
  const Image<glm::vec4> good = noise(64, 64, 58);
  for (const float wrong : {std::nanf(""), std::numeric_limits<float>::infinity(), -std::numeric_limits<float>::infinity()})
    for (int channel = 0; channel < 4; ++channel) {
      Image<glm::vec4> bad = good;
      bad(31, 7)[channel] = wrong;
      EXPECT_THROW(psnrSrgb(bad, good, kBlack), InputError) << wrong << " in channel " << channel;
      EXPECT_THROW(psnrSrgb(good, bad, kBlack), InputError) << wrong << " in channel " << channel;
      EXPECT_THROW(psnrSrgb(bad, bad, kBlack), InputError) << wrong << " in both, channel " << channel;
    }
}

}  // namespace
}  // namespace warpscope
