// Cameras far from the volume and inside its matter: cases 45, 46, 51, 52, 62 and 63. Truth: closed forms in double.
// Mirrors render/core/pixel_grid.h and sample.h.
#include "render/core/pixel_grid.h"

#include <gtest/gtest.h>

#include <cmath>

#include "render/march/own_picture.h"
#include "render/volume/procedural.h"
#include "render/warp/warp.h"
#include "tests/frame_samples.h"
#include "tests/marcher_cases.h"
#include "tests/test_volumes.h"

namespace warpscope {
namespace {

constexpr double kDisplayCode = 1.0 / 255.0;

/// A slab of one value, `thickness` voxels along z.
VolumePtr slab(uint32_t thickness) {
  return makeTestVolume(VoxelType::uint8, {64, 64, thickness}, [](const glm::ivec3&) { return 50.0; });
}

/// Largest difference of a picture's opacities from those of as much matter as the rays have in the box.
double largestError(const Image<glm::vec4>& image, const Camera& camera, const Box& box, double alpha) {
  double largest = 0.0;
  for (uint32_t y = 0; y < camera.height; ++y)
    for (uint32_t x = 0; x < camera.width; ++x) {
      const double expected = -std::expm1(lengthInside(camera, x, y, box) * std::log1p(-alpha));
      largest = std::max(largest, std::abs(static_cast<double>(image(x, y).a) - expected));
    }
  return largest;
}

TEST(Case46, AThinSlabsOpacityDoesNotDependOnTheCamerasDistance) {
  constexpr float kSize = 64.0f;
  for (const uint32_t thickness : {1u, 2u, 3u})
    for (const float alpha : {0.01f, 0.3f, 0.9f}) {
      const VolumePtr volume = slab(thickness);
      const MarcherPtr marcher = makeCpuMarcher(volume, everywhere(alpha));
      MarchSettings settings;
      settings.render.terminateEarly = false;
      settings.render.contribution = 1e-6f;
      for (const float sizes : {1e3f, 1e4f, 1e5f, 1e6f, 4e6f}) {
        const float distance = sizes * kSize;
        const Camera camera = lookingFrom({0.0f, 0.0f, distance}, {}, 24, 24, 0.4f / sizes);
        const Image<glm::vec4> image = rendered(*marcher, camera, settings);
        EXPECT_LT(largestError(image, camera, volume->bounds(), static_cast<double>(alpha)), 1e-5)
            << thickness << " voxels of " << alpha << " from " << sizes << " sizes";
        EXPECT_GT(largestAlpha(image), 0.9f * alpha);
      }
    }
}

TEST(Case51, ASlabSeenAslantHasItsOpacityFromAnyDistance) {
  const VolumePtr volume = slab(4);
  const MarcherPtr marcher = makeCpuMarcher(volume, everywhere(0.2f));
  MarchSettings settings;
  settings.render.terminateEarly = false;
  settings.render.contribution = 1e-6f;
  for (const float sizes : {2.0f, 1e3f, 1e5f, 4e6f})
    for (const glm::vec3& from : {glm::vec3(0.6f, 0.0f, 0.8f), glm::vec3(-0.3f, 0.5f, 0.7f), glm::vec3(0.1f, -0.2f, -1.0f)}) {
      const Camera camera = lookingFrom(64.0f * sizes * glm::normalize(from), {}, 24, 24, 0.4f / sizes);
      // The eye is where single precision puts it, and so is what it sees: compared is the same camera, in double.
      const Image<glm::vec4> image = rendered(*marcher, camera, settings);
      EXPECT_LT(largestError(image, camera, volume->bounds(), 0.2), kDisplayCode) << sizes << " sizes, from " << from.x;
      EXPECT_GT(largestAlpha(image), 0.0f) << sizes;
    }
}

TEST(Case63, SamplesSeenFromFarAwayLieWhereTheyAre) {
  // An opaque slab's front: half a step behind its face, wherever the camera is.
  const VolumePtr volume = slab(4);
  const MarcherPtr marcher = makeCpuMarcher(volume, everywhere(1.0f));
  MarchSettings settings;
  settings.sample.heuristic = Heuristic::entrance;
  for (const float sizes : {1.0f, 1e3f, 1e5f, 4e6f}) {
    const Camera camera = lookingFrom({0.0f, 0.0f, 64.0f * sizes}, {}, 32, 32, 0.4f / sizes);
    const SampleFrame frame = marcher->march(camera, settings);
    ASSERT_GT(frame.size(), 500u) << sizes;
    for (size_t i = 0; i < frame.size(); ++i) {
      const glm::vec3 center = sphereOf(frame, i).center;
      const float cosine = frame.grid().pixels.ray(columnOf(frame.samples[i]), rowOf(frame.samples[i])).cosine;
      ASSERT_NEAR(center.z, 2.0f - 0.5f * settings.render.step * cosine, 0.5f * frame.quantization.depthStep + 2e-5f) << sizes;
    }
  }
}

/// Shells, seen from inside their matter.
struct InsideShells {
  VolumePtr volume = makeProceduralVolume("shells", {64, 64, 64});
  MarcherPtr marcher = makeCpuMarcher(volume, {{{20.0, {0.2f, 0.45f, 0.9f}, 0.0f}, {255.0, {1.0f, 0.5f, 0.2f}, 0.06f}}});

  std::vector<Camera> cameras(uint32_t width, uint32_t height) const {
    const float edge = volume->bounds().extent().x;
    std::vector<Camera> all;
    for (const glm::vec3& from : {glm::vec3(0.0f), glm::vec3(0.02f, 0.015f, 0.04f), glm::vec3(0.2f, 0.1f, 0.15f), glm::vec3(-0.3f, 0.2f, 0.1f)})
      all.push_back(lookingFrom(edge * from, edge * (from + glm::vec3(-0.3f, -0.2f, -0.9f)), width, height));
    return all;
  }
};

TEST(Case45, FromInsideMatterHoldShowsEveryPixelItsOwnSample) {
  const InsideShells shells;
  const auto hold = makeWarp(findWarp("hold"), {});
  for (const Camera& camera : shells.cameras(160, 120))
    for (const auto& heuristic : kHeuristics) {
      MarchSettings settings;
      settings.sample.heuristic = heuristic.value;
      settings.render.contribution = 1e-4f;
      const auto frame = std::make_shared<const SampleFrame>(shells.marcher->march(camera, settings));
      ASSERT_GT(frame->size(), 10000u) << heuristic.name;
      Image<glm::vec4> truth;
      shells.marcher->render(camera, settings.render, truth);
      hold->setFrame(frame, {});
      WarpedImage image;
      hold->draw(camera, {}, image);
      size_t covered = 0;
      for (uint32_t y = 0; y < camera.height; ++y)
        for (uint32_t x = 0; x < camera.width; ++x) {
          const uint32_t id = image.samples(x, y);
          if (id == kNoSample) continue;
          ++covered;
          ASSERT_EQ(columnOf(frame->samples[id]), x);
          ASSERT_EQ(rowOf(frame->samples[id]), y);
          ASSERT_NEAR(image.color(x, y).a, truth(x, y).a, kDisplayCode);
        }
      EXPECT_EQ(covered, frame->size()) << heuristic.name;
    }
}

TEST(Case52, FromInsideMatterSamplesLieInTheirPixels) {
  const InsideShells shells;
  for (const Camera& camera : shells.cameras(1024, 768)) {
    MarchSettings settings;
    settings.sample.heuristic = Heuristic::entrance;
    settings.render.contribution = 1e-4f;
    const SampleFrame frame = shells.marcher->march(camera, settings);
    const SampleGrid grid = frame.grid();
    const Box& bounds = frame.quantization.bounds;
    for (const PackedSample sample : frame.samples) {
      const glm::vec3 center = unpackPosition(sample, grid);
      const glm::dvec3 offset = glm::dvec3(center) - glm::dvec3(camera.eye);
      const double depth = glm::dot(offset, glm::dvec3(camera.forward)), edge = static_cast<double>(pixelEdge(camera));
      const double x = 0.5 * camera.width + glm::dot(offset, glm::dvec3(camera.right)) / (depth * edge);
      const double y = 0.5 * camera.height - glm::dot(offset, glm::dvec3(camera.up)) / (depth * edge);
      // What rounding is declared to move a sample by, of coordinates up to 64: pixels are wide enough from a hundredth of a voxel on.
      if (depth < 0.05 || glm::any(glm::equal(center, bounds.lower)) || glm::any(glm::equal(center, bounds.upper))) continue;
      ASSERT_NEAR(x, columnOf(sample) + 0.5, 0.5 * (0.01 + 64.0 * 0x1p-20 / (depth * edge)));
      ASSERT_NEAR(y, rowOf(sample) + 0.5, 0.5 * (0.01 + 64.0 * 0x1p-20 / (depth * edge)));
    }
  }
}

TEST(Case62, FromInsideMatterDepthsAreWithinHalfAStep) {
  // Matter that is opaque everywhere: the first sample is half a step in front of the eye.
  const VolumePtr volume = makeTestVolume(VoxelType::uint8, {16, 16, 16}, [](const glm::ivec3&) { return 50.0; });
  const MarcherPtr marcher = makeCpuMarcher(volume, everywhere(1.0f));
  for (const float step : {0.001f, 0.01f, 0.5f}) {
    MarchSettings settings;
    settings.render.step = step;
    settings.sample.heuristic = Heuristic::entrance;
    const Camera camera = lookingFrom({1.0f, 2.0f, 3.0f}, {}, 40, 30);
    const SampleFrame frame = marcher->march(camera, settings);
    ASSERT_EQ(frame.size(), 1200u);
    EXPECT_EQ(frame.quantization.nearDepth, 0.0f);
    for (size_t i = 0; i < frame.size(); ++i) {
      const PackedSample sample = frame.samples[i];
      const double cosine = static_cast<double>(frame.grid().pixels.ray(columnOf(sample), rowOf(sample)).cosine);
      const double depthStep = static_cast<double>(frame.quantization.depthStep);
      ASSERT_NEAR(static_cast<double>(depthCode(sample)) * depthStep, 0.5 * static_cast<double>(step) * cosine, 0.5001 * depthStep);
    }
  }
}

}  // namespace
}  // namespace warpscope
