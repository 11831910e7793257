// Frames and cameras for tests of techniques, and what a technique that is exact has to show.
// Frames of made-up spheres: frame_samples.h; scenes: headless.h.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "render/metrics/holes.h"
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

/// Whether it shows something of frames that have samples and nothing else.
inline bool drawsSamples(const WarpDescriptor& technique) { return technique.usesFrame && !technique.uses.segments && !technique.uses.proxy; }

/// Whether each pixel shows one of the frame's samples: some techniques blend them.
inline bool showsSamplesAsTheyAre(const WarpDescriptor& technique) {
  return drawsSamples(technique) && technique.name != "mesh" && technique.name != "rotate";
}

inline size_t coveredPixels(const WarpedImage& image) {
  return static_cast<size_t>(
      std::count_if(image.samples.begin(), image.samples.end(), [](uint32_t id) { return id != kNoSample; }));
}

/// Fails unless the holes of each technique's pictures grow as the camera turns away from the frame's, are counted as
/// the march says, and are left clear.
inline void expectHolesGrowAndStayClear(const Stage& stage,
                                        const std::vector<std::pair<std::string, WarpSettings>>& techniques) {
  const SampleFramePtr frame = stage.frame(stage.camera(300, 300), stage.scene().march);
  for (const auto& [name, settings] : techniques) {
    double before = -1.0;
    for (const double turn : {0.0, 10.0, 30.0, 60.0}) {
      SCOPED_TRACE(name + " " + std::to_string(turn));
      const Camera turned = stage.camera(300, 300, turn);
      Image<glm::vec4> reference;
      stage.marcher().render(turned, stage.scene().march.render, reference);
      const WarpedImage image = stage.draw(name, frame, turned, settings);
      const HoleCount count = countHoles(image, reference);
      size_t holes = 0, background = 0;
      for (size_t i = 0; i < reference.size(); ++i) {
        if (image.samples[i] != kNoSample) continue;
        ASSERT_EQ(image.color[i], glm::vec4(0.0f)) << "an uncovered pixel has a colour";
        (reference[i].a >= 1.0f / 255.0f ? holes : background) += 1;
      }
      EXPECT_EQ(count.holes, holes);
      EXPECT_GT(background, 1000u);
      EXPECT_GT(count.fraction(), before) << "holes grow with the angle";
      before = turn == 0.0 ? count.fraction() - 1e-9 : count.fraction();
      EXPECT_TRUE(turn != 60.0 || count.fraction() > 0.05) << count.fraction();
      EXPECT_TRUE(turn != 0.0 || count.fraction() < 0.02) << count.fraction();
    }
  }
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
