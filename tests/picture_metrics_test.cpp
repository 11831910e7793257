// Metrics of pictures against other implementations' figures for the same pictures, and what must hold of any pictures.
// Mirrors render/metrics/{flip,ssim,psnr,filters}.h. Oracles: flip-evaluator 1.7 (PyPI), scikit-image (Gaussian weights, deviation 1.5, population
// covariance, range 1), both from the pictures that somePicture() describes.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "render/core/color.h"
#include "render/core/error.h"
#include "render/metrics/filters.h"
#include "render/metrics/flip.h"
#include "render/metrics/psnr.h"
#include "render/metrics/ssim.h"

namespace warpscope {
namespace {

constexpr glm::vec3 kBlack(0.0f);

/// Waves in each channel, 0.1 to 0.9 as displayed; `phase` moves them.
Image<glm::vec4> somePicture(double phase, bool hasPatch) {
  Image<glm::vec4> image(96, 64);
  for (uint32_t y = 0; y < image.height(); ++y)
    for (uint32_t x = 0; x < image.width(); ++x) {
      glm::dvec3 shown(0.5 + 0.4 * std::sin(0.21 * x + 0.05 * y + phase), 0.5 + 0.4 * std::cos(0.11 * x - 0.17 * y + phase),
                       0.5 + 0.4 * std::sin(0.07 * x + 0.13 * y + 1.0 + phase));
      if (hasPatch && x >= 40 && x < 56 && y >= 20 && y < 36) shown = {0.95, 0.1, 0.2};
      for (int channel = 0; channel < 3; ++channel) image(x, y)[channel] = linearFromSrgb(static_cast<float>(shown[channel]));
      image(x, y).a = 1.0f;
    }
  return image;
}

TEST(PictureMetrics, FlipIsTheOracles) {
  const FlipResult result = flip(somePicture(0.35, true), somePicture(0.0, false), kBlack);
  EXPECT_NEAR(result.mean, 0.5126898884773254, 1e-4);
  EXPECT_NEAR(result.map(48, 28), 0.9813824, 1e-3);
  EXPECT_NEAR(result.map(5, 5), 0.42010707, 1e-3);
  EXPECT_NEAR(result.map(95, 63), 0.42050844, 1e-3);  // the corner, where filters reach over the border
  EXPECT_NEAR(result.map(40, 20), 0.911862, 1e-3);
}

TEST(PictureMetrics, SsimAndPsnrAreTheOracles) {
  EXPECT_NEAR(ssimSrgb(somePicture(0.35, true), somePicture(0.0, false), kBlack), 0.7493304047942934, 1e-5);
  EXPECT_NEAR(psnrSrgb(somePicture(0.35, true), somePicture(0.0, false), kBlack), 15.684411175411423, 1e-4);
}

TEST(PictureMetrics, EqualPicturesDoNotDiffer) {
  const Image<glm::vec4> image = somePicture(0.2, true);
  const FlipResult result = flip(image, image, kBlack);
  EXPECT_EQ(result.mean, 0.0);
  for (const float value : result.map) ASSERT_EQ(value, 0.0f);
  EXPECT_NEAR(ssimSrgb(image, image, kBlack), 1.0, 1e-6);
}

TEST(PictureMetrics, FlipDoesNotDependOnTheOrderAndStaysInRange) {
  const Image<glm::vec4> a = somePicture(1.0, false), b = somePicture(0.0, true);
  const FlipResult forth = flip(a, b, kBlack), back = flip(b, a, kBlack);
  EXPECT_NEAR(forth.mean, back.mean, 1e-6);
  Image<glm::vec4> black(96, 64, glm::vec4(0.0f)), white(96, 64, glm::vec4(1.0f));
  for (const float value : flip(black, white, kBlack).map) {
    ASSERT_GT(value, 0.9f);
    ASSERT_LE(value, 1.0f);
  }
}

TEST(PictureMetrics, ASmallPictureIsOneOfItsKind) {
  // One colour everywhere: no size makes a difference.
  const glm::vec4 p(0.2f, 0.5f, 0.1f, 1.0f), q(0.3f, 0.4f, 0.2f, 1.0f);
  const double large = flip(Image<glm::vec4>(64, 64, p), Image<glm::vec4>(64, 64, q), kBlack).mean;
  const double largeSsim = ssimSrgb(Image<glm::vec4>(64, 64, p), Image<glm::vec4>(64, 64, q), kBlack);
  for (const auto& [width, height] : {std::pair(1u, 1u), std::pair(3u, 1u), std::pair(1u, 7u), std::pair(17u, 5u), std::pair(12u, 40u)}) {
    EXPECT_NEAR(flip(Image<glm::vec4>(width, height, p), Image<glm::vec4>(width, height, q), kBlack).mean, large, 1e-5);
    EXPECT_NEAR(ssimSrgb(Image<glm::vec4>(width, height, p), Image<glm::vec4>(width, height, q), kBlack), largeSsim, 1e-5);
  }
}

TEST(PictureMetrics, TransparentPixelsShowTheBackground) {
  const Image<glm::vec4> clear(40, 30, glm::vec4(0.0f)), red(40, 30, glm::vec4(1.0f, 0.0f, 0.0f, 1.0f));
  EXPECT_NEAR(flip(clear, red, {1.0f, 0.0f, 0.0f}).mean, 0.0, 1e-6);
  EXPECT_NEAR(ssimSrgb(clear, red, {1.0f, 0.0f, 0.0f}), 1.0, 1e-6);
  EXPECT_GT(flip(clear, red, kBlack).mean, 0.3);
}

TEST(PictureMetrics, WhatCannotBeComparedIsRefused) {
  const Image<glm::vec4> image(8, 8, glm::vec4(0.5f)), other(8, 9, glm::vec4(0.5f)), none;
  Image<glm::vec4> broken = image;
  broken(3, 3).g = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THROW(flip(image, other, kBlack), InputError);
  EXPECT_THROW(flip(none, none, kBlack), InputError);
  EXPECT_THROW(flip(image, broken, kBlack), InputError);
  EXPECT_THROW(flip(image, image, kBlack, 0.0f), InputError);
  EXPECT_THROW(ssimSrgb(image, other, kBlack), InputError);
  EXPECT_THROW(ssimSrgb(broken, image, kBlack), InputError);
}

TEST(Filters, RowsAndColumnsAreTheSumsThatTheySayTheyAre) {
  Image<float> image(7, 5);
  for (size_t i = 0; i < image.size(); ++i) image[i] = static_cast<float>((i * 37) % 11);
  const std::array<float, 5> kernel{0.1f, -0.4f, 0.7f, 0.25f, 2.0f};
  Image<float> rows, columns;
  filterRows(image, kernel, rows);
  filterColumns(image, kernel, columns);
  const auto at = [&](int x, int y) {
    return image(static_cast<uint32_t>(std::clamp(x, 0, 6)), static_cast<uint32_t>(std::clamp(y, 0, 4)));
  };
  for (int y = 0; y < 5; ++y)
    for (int x = 0; x < 7; ++x) {
      float alongX = 0.0f, alongY = 0.0f;
      for (int j = 0; j < 5; ++j) {
        alongX += kernel[static_cast<size_t>(j)] * at(x + j - 2, y);
        alongY += kernel[static_cast<size_t>(j)] * at(x, y + j - 2);
      }
      EXPECT_NEAR(rows(static_cast<uint32_t>(x), static_cast<uint32_t>(y)), alongX, 1e-5);
      EXPECT_NEAR(columns(static_cast<uint32_t>(x), static_cast<uint32_t>(y)), alongY, 1e-5);
    }
}

}  // namespace
}  // namespace warpscope
