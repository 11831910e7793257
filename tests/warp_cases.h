// Frames and cameras for tests of techniques, and what a technique that is exact has to show.
// Frames of made-up spheres: frame_samples.h; scenes: headless.h.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <vector>

#include "tests/frame_samples.h"
#include "tests/headless.h"

namespace warpscope {

/// Sizes that are no multiple of a tile's, and images of one row, column or pixel.
inline constexpr glm::uvec2 kOddSizes[] = {{333, 217}, {64, 301}, {1, 1}, {1, 77}, {129, 1}, {511, 512}};

inline MarchSettings withRadius(const Scene& scene, RadiusPolicy policy) {
  MarchSettings settings = scene.march;
  settings.sample.radiusPolicy = policy;
  return settings;
}

/// Fails unless every pixel of `image` shows exactly the sample that `expected` names, in exactly its colour.
inline void expectExactly(const WarpedImage& image, const Image<uint32_t>& expected, const SampleFrame& frame) {
  ASSERT_EQ(image.samples.width(), expected.width());
  ASSERT_EQ(image.samples.height(), expected.height());
  size_t wrongSample = 0, wrongColor = 0, first = expected.size();
  for (size_t i = 0; i < expected.size(); ++i) {
    wrongSample += image.samples[i] != expected[i];
    if (image.samples[i] != expected[i]) first = std::min(first, i);
    const glm::vec4 color = expected[i] == kNoSample ? glm::vec4(0.0f) : decodeRgba8(frame.colors[expected[i]]);
    wrongColor += image.color[i] != color;
  }
  EXPECT_EQ(wrongSample, 0u) << "of " << expected.size() << " pixels; the first is (" << first % expected.width()
                             << ", " << first / expected.width() << ")";
  EXPECT_EQ(wrongColor, 0u);
}

inline size_t coveredPixels(const WarpedImage& image) {
  return static_cast<size_t>(
      std::count_if(image.samples.begin(), image.samples.end(), [](uint32_t id) { return id != kNoSample; }));
}

/// A camera at `z`, looking along -z.
inline Camera frontCamera(uint32_t width, uint32_t height, float z = 10.0f) {
  Camera camera;
  camera.eye = {0.0f, 0.0f, z};
  camera.width = width;
  camera.height = height;
  return camera;
}

/// A frame of given spheres (frameOfSpheres), seen from z = 64, with pixels `cell` wide in the plane z = 0. Radii are
/// powers of two.
inline SampleFramePtr makeFrame(const std::vector<Sphere>& spheres, float cell = 0.25f, uint32_t side = 63) {
  auto frame = std::make_shared<SampleFrame>(frameOfSpheres(spheres, 16.0f, cell, side, 64.0f));
  for (size_t i = 0; i < spheres.size(); ++i) frame->colors[i] = 0xff000000u | static_cast<uint32_t>(40 + 40 * i);
  return frame;
}

/// A stage for frames that no volume stands behind.
inline Stage syntheticStage(gl::Platform platform = gl::Platform::automatic) {
  return Stage(smallScene("block", 16), platform);
}

}  // namespace warpscope
