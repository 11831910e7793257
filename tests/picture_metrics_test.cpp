// FLIP's map against another implementation's, and what must hold of any pictures. Means, identical and broken ones: stability/metrics_test.cpp.
// Mirrors render/metrics/{flip,ssim,psnr,filters,display_curve}.h. The figures: metric_pictures.h.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "render/base/error.h"
#include "render/metrics/display_curve.h"
#include "render/metrics/filters.h"
#include "render/metrics/flip.h"
#include "render/metrics/psnr.h"
#include "render/metrics/ssim.h"
#include "tests/metric_pictures.h"

namespace warpscope {
namespace {

constexpr glm::vec3 kBlack(0.0f);

TEST(PictureMetrics, TheFlipMapIsTheOracles) {
  const FlipResult result = flip(somePicture(0.35, true), somePicture(0.0, false), kBlack);
  EXPECT_NEAR(result.map(48, 28), 0.9813824, 1e-3);
  EXPECT_NEAR(result.map(5, 5), 0.42010707, 1e-3);
  EXPECT_NEAR(result.map(95, 63), 0.42050844, 1e-3);  // the corner, where filters reach over the border
  EXPECT_NEAR(result.map(40, 20), 0.911862, 1e-3);
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
  // More rows than a strip has, and widths around those of vectors.
  for (const auto& size : {std::pair(1, 1), std::pair(7, 5), std::pair(64, 33), std::pair(67, 70)}) {
    const int width = size.first, height = size.second;
    Image<float> image(static_cast<uint32_t>(width), static_cast<uint32_t>(height));
    for (size_t i = 0; i < image.size(); ++i) image[i] = static_cast<float>((i * 37) % 11);
    const std::array<float, 5> along{0.1f, -0.4f, 0.7f, 0.25f, 2.0f};
    const std::array<float, 3> across{0.5f, -1.0f, 3.0f};
    const auto at = [&](int x, int y) {
      return image(static_cast<uint32_t>(std::clamp(x, 0, width - 1)), static_cast<uint32_t>(std::clamp(y, 0, height - 1)));
    };
    size_t rows = 0;
    const double sum = sumOverStrips<RowStrip>(image.height(), [&](uint32_t begin, uint32_t end, RowStrip& strip) {
      strip.filter(image, begin, end, 1, along);
      std::vector<float> row = rowBuffer(image.width());
      for (uint32_t y = begin; y < end; ++y)
        for (const float before : {0.0f, 1000.0f}) {
          std::fill(row.begin(), row.end(), before);
          strip.filterColumns(y, across, row.data(), before != 0.0f);
          for (int x = 0; x < width; ++x) {
            float expected = before;
            for (int j = 0; j < 3; ++j)
              for (int i = 0; i < 5; ++i)
                expected += across[static_cast<size_t>(j)] * along[static_cast<size_t>(i)] * at(x + i - 2, static_cast<int>(y) + j - 1);
            EXPECT_NEAR(row[static_cast<size_t>(x)], expected, 1e-3) << x << " " << y;
          }
        }
      return static_cast<double>(end - begin);
    });
    rows += static_cast<size_t>(sum);
    EXPECT_EQ(rows, image.height());
  }
}

TEST(DisplayCurve, IsTheStandards) {
  float last = 0.0f;
  for (int i = 0; i <= 200000; ++i) {
    const float linear = static_cast<float>(i) / 200000.0f;
    const double truth = linear <= 0.0031308f ? 12.92 * linear : 1.055 * std::pow(static_cast<double>(linear), 1.0 / 2.4) - 0.055;
    const float srgb = srgbOf(linear);
    ASSERT_NEAR(srgb, truth, 2e-7) << linear;
    ASSERT_NEAR(linearOf(static_cast<float>(truth)), linear, 4e-7) << linear;  // half an ulp of the argument is 1.4e-7 already
    ASSERT_GE(srgb, last - 1.2e-7f) << linear;
    last = srgb;
  }
  EXPECT_EQ(srgbOf(0.0f), 0.0f);
  EXPECT_EQ(srgbOf(1.0f), 1.0f);
}

}  // namespace
}  // namespace warpscope
