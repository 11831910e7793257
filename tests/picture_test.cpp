// PNG files: what is written is read back, by a decoder that is not ours, whatever the size.
// Mirrors app/picture/picture.h.
#include "app/picture/picture.h"

#include <gtest/gtest.h>

#include <random>

#include "render/base/error.h"
#include "tests/test_folder.h"

namespace warpscope {
namespace {

/// Flat areas, gradients and noise, so that every filter has its rows; alpha as well.
Image<Rgba8> mixture(uint32_t width, uint32_t height) {
  std::mt19937 random(5);
  Image<Rgba8> picture(width, height);
  for (uint32_t y = 0; y < height; ++y)
    for (uint32_t x = 0; x < width; ++x)
      picture(x, y) = y % 5 == 0   ? 0xff102030u
                      : y % 5 == 1 ? (x & 255) * 0x01010101u
                      : y % 5 == 2 ? (y & 255) * 0x01000100u
                      : y % 5 == 3 ? ((x + y) & 255) * 0x00010001u
                                   : static_cast<Rgba8>(random());
  return picture;
}

TEST(Picture, WhatIsWrittenIsReadBack) {
  const TestFolder folder;
  for (const auto& [width, height] : {std::pair{1u, 1u}, {16384u, 3u}, {2u, 16384u}, {333u, 217u}, {1024u, 1024u}}) {
    const Image<Rgba8> picture = mixture(width, height);
    EXPECT_TRUE(readPng(folder.write("a.png", encodePng(picture))) == picture) << width << "x" << height;
  }
  EXPECT_LT(encodePng(Image<Rgba8>(1024, 1024, 0xff112233u)).size(), 100'000u) << "flat pictures are small";
}

TEST(Picture, APictureWithoutSamplesIsShownAsAWarpedOneThatIsCovered) {
  WarpedImage image;
  image.color.resize(70, 41);
  for (size_t i = 0; i < image.color.size(); ++i) {
    const float alpha = static_cast<float>(i % 11) / 10.0f;
    image.color[i] = {alpha * static_cast<float>(i % 7) / 6.0f, 0.5f * alpha, 0.25f * alpha, alpha};
  }
  image.samples.resize(70, 41, kNotASample);
  const glm::vec3 background(0.1f, 0.4f, 0.9f);
  const Image<Rgba8> shown = toScreen(image.color, background);
  EXPECT_TRUE(shown == toScreen(image, background));
  EXPECT_TRUE(shown == toScreen(image, background, {.uncovered = 0xff00ffffu})) << "every pixel is covered";
  EXPECT_FALSE(shown == toScreen(image.color, glm::vec3(0.0f)));
}

TEST(Picture, WhatIsTooLargeForAFileIsKnownBefore) {
  EXPECT_TRUE(fitsPng(16384, 16384));
  EXPECT_TRUE(fitsPng(1, 1));
  EXPECT_FALSE(fitsPng(5 * 4096, 11 * 4096)) << "what encoders count in 32 bits";
  EXPECT_FALSE(fitsPng(1u << 31, 1));
  EXPECT_FALSE(fitsPng(uint64_t{1} << 40, uint64_t{1} << 40));
}

TEST(Picture, EncodingCanBeStoppedAndRefusesNothing) {
  std::stop_source source;
  source.request_stop();
  EXPECT_THROW(encodePng(mixture(100, 100), source.get_token()), OperationCancelled);
  EXPECT_THROW(encodePng({}), InputError);
}

}  // namespace
}  // namespace warpscope
