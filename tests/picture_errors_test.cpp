// A judge says what the single metrics say, and splits it by what the frame knew.
// Mirrors render/metrics/picture_errors.h.
#include "render/metrics/picture_errors.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <limits>
#include <random>

#include "render/base/error.h"
#include "render/core/color.h"
#include "render/metrics/holes.h"
#include "render/metrics/psnr.h"
#include "render/metrics/ssim.h"

namespace warpscope {
namespace {

constexpr glm::vec3 kBackground(0.1f, 0.0f, 0.3f);

WarpedImage noise(uint32_t width, uint32_t height, uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> unit(0.0f, 1.0f);
  WarpedImage image{Image<glm::vec4>(width, height), Image<uint32_t>(width, height)};
  for (size_t i = 0; i < image.color.size(); ++i) {
    const float alpha = unit(random);
    image.color[i] = alpha * glm::vec4(unit(random), unit(random), unit(random), 1.0f);
    image.samples[i] = random() % 3 == 0 ? kNoSample : 0;
  }
  return image;
}

TEST(PictureErrors, AreThoseOfTheSingleMetrics) {
  for (const auto& [width, height] : {std::pair(1u, 1u), std::pair(7u, 3u), std::pair(100u, 70u)}) {
    const WarpedImage image = noise(width, height, 3), reference = noise(width, height, 4);
    const PictureJudge judge(reference.color, kBackground, 30.0f);
    Image<float> map;
    const PictureErrors errors = judge.errorsOf(image, nullptr, &map);
    EXPECT_DOUBLE_EQ(errors.psnrDb, psnrSrgb(image.color, reference.color, kBackground));
    EXPECT_DOUBLE_EQ(errors.ssim, ssimSrgb(image.color, reference.color, kBackground));
    const FlipResult flipped = flip(image.color, reference.color, kBackground, 30.0f);
    EXPECT_DOUBLE_EQ(errors.flip, flipped.mean);
    EXPECT_EQ(map, flipped.map);
    EXPECT_EQ(errors.holeFraction, countHoles(image, reference.color).fraction());
    EXPECT_FALSE(errors.flipVisible || errors.flipDisoccluded || errors.psnrVisibleDb || errors.psnrDisoccludedDb);

    double squares = 0.0;
    for (size_t i = 0; i < map.size(); ++i) {
      const glm::dvec3 difference = glm::dvec3(glm::vec3(over(image.color[i], {kBackground, 1.0f}))) -
                                    glm::dvec3(glm::vec3(over(reference.color[i], {kBackground, 1.0f})));
      squares += glm::dot(difference, difference);
    }
    EXPECT_NEAR(errors.psnrLinearDb, -10.0 * std::log10(squares / (3.0 * static_cast<double>(map.size()))), 1e-4);
  }
}

TEST(PictureErrors, EqualPicturesHaveNone) {
  const WarpedImage image = noise(90, 50, 8);
  const PictureErrors errors = PictureJudge(image.color, kBackground).errorsOf(image);
  EXPECT_EQ(errors.psnrDb, std::numeric_limits<double>::infinity());
  EXPECT_EQ(errors.psnrLinearDb, std::numeric_limits<double>::infinity());
  EXPECT_EQ(errors.flip, 0.0);
  EXPECT_NEAR(errors.ssim, 1.0, 1e-6);
}

TEST(PictureErrors, KnownSquaresOfLinearLight) {
  // Grey of 0.5 against black: 6.02 dB in linear light, 20 log10(1 / 0.7354) displayed.
  const WarpedImage image{Image<glm::vec4>(20, 20, glm::vec4(0.5f, 0.5f, 0.5f, 1.0f)), Image<uint32_t>(20, 20, 0)};
  const PictureErrors errors = PictureJudge(Image<glm::vec4>(20, 20, glm::vec4(0, 0, 0, 1)), kBackground).errorsOf(image);
  EXPECT_NEAR(errors.psnrLinearDb, 6.0205999, 1e-5);
  EXPECT_NEAR(errors.psnrDb, -20.0 * std::log10(1.055 * std::pow(0.5, 1.0 / 2.4) - 0.055), 1e-5);
}

TEST(PictureErrors, AreSplitByWhatTheFrameKnew) {
  const uint32_t width = 80, height = 60;
  const WarpedImage image = noise(width, height, 5), reference = noise(width, height, 6);
  Image<Visibility> mask(width, height);
  std::mt19937 random(9);
  for (Visibility& kind : mask) kind = static_cast<Visibility>(random() % 3);
  Image<float> map;
  const PictureErrors errors = PictureJudge(reference.color, kBackground).errorsOf(image, &mask, &map);
  ASSERT_TRUE(errors.flipVisible && errors.flipDisoccluded && errors.psnrVisibleDb && errors.psnrDisoccludedDb);
  for (const Visibility kind : {Visibility::visible, Visibility::disoccluded}) {
    double flipSum = 0.0, squares = 0.0, count = 0.0;
    for (size_t i = 0; i < mask.size(); ++i) {
      if (mask[i] != kind) continue;
      ++count;
      flipSum += static_cast<double>(map[i]);
      for (int channel = 0; channel < 3; ++channel) {
        const auto shown = [&](const Image<glm::vec4>& picture) {
          return static_cast<double>(srgbFromLinear(glm::clamp(over(picture[i], {kBackground, 1.0f})[channel], 0.0f, 1.0f)));
        };
        squares += std::pow(shown(image.color) - shown(reference.color), 2.0);
      }
    }
    const bool isVisible = kind == Visibility::visible;
    EXPECT_NEAR(isVisible ? *errors.flipVisible : *errors.flipDisoccluded, flipSum / count, 1e-9);
    EXPECT_NEAR(isVisible ? *errors.psnrVisibleDb : *errors.psnrDisoccludedDb, -10.0 * std::log10(squares / (3.0 * count)), 1e-4);
  }
  // Errors in visible places alone are theirs alone.
  WarpedImage mixed = reference;
  for (size_t i = 0; i < mask.size(); ++i)
    if (mask[i] == Visibility::visible) mixed.color[i] = image.color[i];
  const PictureErrors partial = PictureJudge(reference.color, kBackground).errorsOf(mixed, &mask);
  EXPECT_EQ(partial.psnrDisoccludedDb, std::numeric_limits<double>::infinity());
  EXPECT_EQ(partial.psnrVisibleDb, errors.psnrVisibleDb);
}

TEST(PictureErrors, OfAKindThatNoPixelIsThereIsNothing) {
  const WarpedImage image = noise(30, 20, 5), reference = noise(30, 20, 6);
  const PictureJudge judge(reference.color, kBackground);
  const Image<Visibility> allVisible(30, 20, Visibility::visible), allEmpty(30, 20, Visibility::empty);
  const PictureErrors visible = judge.errorsOf(image, &allVisible), empty = judge.errorsOf(image, &allEmpty);
  EXPECT_FALSE(visible.flipDisoccluded || visible.psnrDisoccludedDb || empty.flipVisible || empty.psnrVisibleDb || empty.flipDisoccluded);
  EXPECT_NEAR(visible.flipVisible.value(), visible.flip, 1e-7);
  EXPECT_NEAR(visible.psnrVisibleDb.value(), visible.psnrDb, 1e-6);
}

TEST(PictureErrors, TheSameWhateverTheNumberOfThreads) {
  const WarpedImage image = noise(300, 200, 1), reference = noise(300, 200, 2);
  const auto errors = [&] { return PictureJudge(reference.color, kBackground).errorsOf(image); };
  const PictureErrors parallel = errors();
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const PictureErrors alone = errors();
  EXPECT_EQ(alone.psnrDb, parallel.psnrDb);
  EXPECT_EQ(alone.psnrLinearDb, parallel.psnrLinearDb);
  EXPECT_EQ(alone.ssim, parallel.ssim);
  EXPECT_EQ(alone.flip, parallel.flip);
}

TEST(PictureErrors, WhatCannotBeComparedIsRefused) {
  const WarpedImage image = noise(10, 8, 1);
  const PictureJudge judge(image.color, kBackground);
  const Image<Visibility> wrongMask(8, 10, Visibility::visible);
  EXPECT_THROW(judge.errorsOf(noise(8, 10, 1)), InputError);
  EXPECT_THROW(judge.errorsOf(image, &wrongMask), InputError);
  WarpedImage broken = image;
  broken.color(9, 7).a = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THROW(judge.errorsOf(broken), InputError);
  EXPECT_THROW(PictureJudge(broken.color, kBackground), InputError);
  EXPECT_THROW(PictureJudge({}, kBackground), InputError);
  EXPECT_THROW(PictureJudge(image.color, kBackground, 0.5f), InputError);
}

}  // namespace
}  // namespace warpscope
