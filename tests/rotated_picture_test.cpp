// A frame's own picture, turned about its eye: every pixel's place against long double, and the whole against the
// volume marched for that camera. Mirrors render/warp/rotated_picture.h.
#include "render/warp/rotated_picture.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "render/base/error.h"
#include "render/metrics/flip.h"
#include "tests/headless.h"
#include "tests/marcher_cases.h"
#include "tests/moved_cameras.h"

namespace warpscope {
namespace {

/// Red is the column, green the row, of a picture without holes.
WarpedImage coordinates(const Camera& camera) {
  WarpedImage image;
  image.color.resize(camera.width, camera.height);
  image.samples.resize(camera.width, camera.height);
  for (uint32_t y = 0; y < camera.height; ++y)
    for (uint32_t x = 0; x < camera.width; ++x) {
      image.color(x, y) = glm::vec4(x, y, 0.0f, 1.0f);
      image.samples(x, y) = y * camera.width + x;
    }
  return image;
}

struct Place {
  long double x, y;  // pixels, centres at +0.5
  bool isInFront;
};

/// By the conventions of core/camera.h: the direction of a pixel, in coordinates along another camera's axes.
Place placeIn(const Camera& from, const Camera& camera, uint32_t column, uint32_t row) {
  using Vec = glm::vec<3, long double>;
  const long double edge = 2.0L * camera.tanHalfFovY / camera.height,
                    edgeOfFrom = 2.0L * from.tanHalfFovY / from.height;
  const Vec direction = Vec(camera.forward) + (column + 0.5L - 0.5L * camera.width) * edge * Vec(camera.right) +
                        (0.5L * camera.height - (row + 0.5L)) * edge * Vec(camera.up);
  // Cramer's rule: the axes may be off by roundings.
  const Vec right(from.right), up(from.up), forward(from.forward);
  const long double whole = glm::dot(right, glm::cross(up, forward));
  const long double x = glm::dot(direction, glm::cross(up, forward)) / whole,
                    y = glm::dot(right, glm::cross(direction, forward)) / whole,
                    z = glm::dot(right, glm::cross(up, direction)) / whole;
  return {0.5L * from.width + x / (z * edgeOfFrom), 0.5L * from.height - y / (z * edgeOfFrom), z > 0.0L};
}

TEST(RotatedPicture, EveryPixelShowsWhatLiesInItsDirection) {
  for (const uint32_t seed : {1u, 2u, 3u, 4u, 5u, 6u, 7u, 8u}) {
    std::mt19937 random(seed);
    const auto uniform = [&](float from, float to) { return std::uniform_real_distribution<float>(from, to)(random); };
    const float far = seed % 2 == 0 ? 1e7f : 30.0f;
    const float tanHalfFovY = seed == 8 ? 1e-7f : uniform(0.05f, 1.5f), mostDeg = 40.0f * std::min(1.0f, tanHalfFovY);
    Camera from = lookingFrom({uniform(-far, far), uniform(-far, far), far}, {}, 97, 64, tanHalfFovY);
    // Axes need not be exactly orthonormal: isUsable(). Every third picture's are not.
    if (seed % 3 == 0) {
      from.right *= 1.0004f;
      from.up = glm::normalize(from.up + 9e-4f * from.right);
      ASSERT_TRUE(isUsable(from));
    }
    Camera camera = turned(from, uniform(-mostDeg, mostDeg), uniform(-mostDeg, mostDeg));
    camera.tanHalfFovY *= uniform(0.3f, 2.0f);
    camera.width = 61 + seed;
    camera.height = 83 - seed;
    const WarpedImage own = coordinates(from);
    WarpedImage image;
    drawRotated(own, from, camera, image);
    ASSERT_EQ(image.color.width(), camera.width);
    ASSERT_EQ(image.samples.height(), camera.height);
    size_t covered = 0;
    constexpr long double kTolerance = 1.0L / 2000;
    for (uint32_t y = 0; y < camera.height; ++y)
      for (uint32_t x = 0; x < camera.width; ++x) {
        const Place place = placeIn(from, camera, x, y);
        const bool isCovered = image.samples(x, y) != kNoSample;
        covered += isCovered;
        const long double inside = std::min({place.x, from.width - place.x, place.y, from.height - place.y});
        if (std::abs(inside) > kTolerance || !place.isInFront)
          ASSERT_EQ(isCovered, place.isInFront && inside > 0.0L) << "seed " << seed;
        if (!isCovered) {
          ASSERT_EQ(image.color(x, y), glm::vec4(0.0f));
          continue;
        }
        const long double column = std::clamp<long double>(place.x - 0.5L, 0.0L, from.width - 1.0L);
        const long double row = std::clamp<long double>(place.y - 0.5L, 0.0L, from.height - 1.0L);
        ASSERT_NEAR(static_cast<double>(image.color(x, y).r), static_cast<double>(column), 1.0 / 2000)
            << "seed " << seed;
        ASSERT_NEAR(static_cast<double>(image.color(x, y).g), static_cast<double>(row), 1.0 / 2000) << "seed " << seed;
        ASSERT_NEAR(image.color(x, y).a, 1.0f, 1e-6f);
        const uint32_t sample = image.samples(x, y);
        ASSERT_LE(std::abs(static_cast<double>(column) - sample % from.width), 0.5 + 1.0 / 2000);
        ASSERT_LE(std::abs(static_cast<double>(row) - static_cast<double>(sample / from.width)), 0.5 + 1.0 / 2000);
      }
    EXPECT_GT(covered, 100u) << "seed " << seed;
  }
}

TEST(RotatedPicture, TheSameCameraShowsTheSameAndTheEyeDoesNotMatter) {
  for (const Camera& from : {lookingFrom({3.0f, 2.0f, 40.0f}, {}, 41, 30),
                             turned(lookingFrom({3.0f, 2.0f, 40.0f}, {}, 128, 128, 1.2f), 13.0f, -7.0f)}) {
    WarpedImage own = coordinates(from);
    own.samples(7, 5) = kNoSample;
    own.color(7, 5) = glm::vec4(0.0f);
    WarpedImage image;
    drawRotated(own, from, from, image);
    EXPECT_TRUE(sameBits(image.color, own.color));
    EXPECT_TRUE(image.samples == own.samples);

    const Camera camera = turned(from, 10.0f, 5.0f);
    WarpedImage near, far;
    drawRotated(own, from, camera, near);
    Camera farFrom = from, farCamera = camera;
    farFrom.eye = farCamera.eye = {1e7f, -3e7f, 2e6f};
    drawRotated(own, farFrom, farCamera, far);
    EXPECT_TRUE(sameBits(near.color, far.color));
  }
}

/// Three pixels for one: the middle ones are the picture's own.
TEST(RotatedPicture, AnotherSizeKeepsPlacesAndDirections) {
  const Camera from = lookingFrom({3.0f, 2.0f, 40.0f}, {}, 20, 15);
  Camera camera = from;
  camera.width *= 3;
  camera.height *= 3;
  const WarpedImage own = coordinates(from);
  WarpedImage image;
  drawRotated(own, from, camera, image);
  for (uint32_t y = 0; y < from.height; ++y)
    for (uint32_t x = 0; x < from.width; ++x) {
      EXPECT_EQ(image.color(3 * x + 1, 3 * y + 1), own.color(x, y));
      EXPECT_EQ(image.samples(3 * x + 1, 3 * y + 1), own.samples(x, y));
    }
  EXPECT_EQ(image.color(0, 0), own.color(0, 0)) << "towards the border the outermost centres stay";
}

TEST(RotatedPicture, WhatTheFrameDoesNotShowIsNotCovered) {
  const Camera from = lookingFrom({0.0f, 0.0f, 40.0f}, {}, 20, 15);
  const WarpedImage own = coordinates(from);
  WarpedImage image;
  for (const float degrees : {120.0f, 180.0f}) {
    drawRotated(own, from, turned(from, degrees, 0.0f), image);
    for (const uint32_t sample : image.samples) EXPECT_EQ(sample, kNoSample);
  }
  Camera wide = from;
  wide.tanHalfFovY *= 3.0f;
  wide.width *= 3;
  wide.height *= 3;
  drawRotated(own, from, wide, image);
  for (uint32_t y = 0; y < wide.height; ++y)
    for (uint32_t x = 0; x < wide.width; ++x)
      EXPECT_EQ(image.samples(x, y) != kNoSample, x >= 20 && x < 40 && y >= 15 && y < 30) << x << ", " << y;
}

/// One pixel in which something is seen fades into the nothing around it.
TEST(RotatedPicture, WhereNothingIsSeenCountsAsNothing) {
  const Camera from = lookingFrom({0.0f, 0.0f, 40.0f}, {}, 5, 5);
  WarpedImage own;
  own.color.resize(5, 5);
  own.samples.resize(5, 5, kNoSample);
  own.color(2, 2) = {0.5f, 0.25f, 0.0f, 0.5f};
  own.samples(2, 2) = 77;
  Camera camera = from;
  camera.width = camera.height = 40;  // eight pixels for one
  WarpedImage image;
  drawRotated(own, from, camera, image);
  for (uint32_t y = 0; y < 40; ++y)
    for (uint32_t x = 0; x < 40; ++x) {
      const float awayX = std::abs((static_cast<float>(x) + 0.5f) / 8.0f - 2.5f),
                  awayY = std::abs((static_cast<float>(y) + 0.5f) / 8.0f - 2.5f);
      const float share = std::max(0.0f, 1.0f - awayX) * std::max(0.0f, 1.0f - awayY);
      ASSERT_EQ(image.samples(x, y), share > 0.0f ? 77u : kNoSample);
      for (int channel = 0; channel < 4; ++channel)
        ASSERT_NEAR(image.color(x, y)[channel], share * own.color(2, 2)[channel], 1e-6f);
    }
}

TEST(RotatedPicture, RefusesUnusableCamerasAndEndsWhenItIsTold) {
  const Camera from = lookingFrom({0.0f, 0.0f, 40.0f}, {}, 20, 15);
  const WarpedImage own = coordinates(from);
  WarpedImage image;
  Camera broken = from;
  broken.tanHalfFovY = std::nanf("");
  EXPECT_THROW(drawRotated(own, from, broken, image), InputError);
  EXPECT_THROW(drawRotated(own, broken, from, image), InputError);
  std::stop_source stop;
  stop.request_stop();
  EXPECT_THROW(drawRotated(own, from, from, image, stop.get_token()), OperationCancelled);
}

/// The volume marched for the turned camera is the truth; what streaming viewers show meanwhile is what has to be
/// beaten.
TEST(RotatedPicture, IsWhatTheVolumeLooksLikeFromThere) {
  struct Turn {
    const char* name;
    float rightDeg, upDeg, zoom;
    uint32_t width, height;
  };
  constexpr Turn kTurns[] = {{"right", 4.0f, 0.0f, 1.0f, 120, 100},
                             {"up", 0.0f, -3.0f, 1.0f, 120, 100},
                             {"nearer", 0.0f, 0.0f, 0.7f, 120, 100},
                             {"larger", 0.0f, 0.0f, 1.0f, 150, 125},
                             {"all", 3.0f, 2.0f, 0.9f, 97, 81}};
  for (const char* name : {"block", "shells"}) {
    const Stage stage(smallScene(name));
    Camera from = stage.camera(120, 100);
    from.tanHalfFovY *= 1.3f;  // with room to turn
    const SampleFramePtr frame = stage.frame(from, stage.scene().march);
    const WarpedImage own = ownImageOf(*frame);
    for (const Turn& turn : kTurns) {
      Camera camera = turned(from, turn.rightDeg, turn.upDeg);
      camera.tanHalfFovY *= turn.zoom;
      camera.width = turn.width;
      camera.height = turn.height;
      const Image<glm::vec4> truth = rendered(stage.marcher(), camera, stage.scene().march);
      WarpedImage image;
      drawRotated(own, from, camera, image);
      const double error = flip(image.color, truth, {}).mean,
                   held = flip(stage.draw("hold", frame, camera).color, truth, {}).mean;
      // Where no direction is another, `hold` shows the nearest pixel, and is wrong by that alone.
      const bool isMoved = turn.rightDeg != 0.0f || turn.upDeg != 0.0f || turn.zoom != 1.0f;
      EXPECT_LT(error, (isMoved ? 0.1 : 0.6) * held) << name << ", " << turn.name;
      EXPECT_LT(error, 0.025) << name << ", " << turn.name;
    }
  }
}

}  // namespace
}  // namespace warpscope
