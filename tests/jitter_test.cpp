// Noise whose neighbours differ, and rays whose samples it moves: rings become noise, and nothing else changes.
// Mirrors render/effects/jitter.h.
#include "render/effects/jitter.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <vector>

#include "app/scene/scene.h"
#include "codec_frames.h"
#include "headless.h"
#include "marcher_cases.h"
#include "test_volumes.h"

namespace warpscope {
namespace {

/// How much means of squares of `side` pixels differ, of a picture as wide as the noise that goes on beyond its borders.
double varianceOfMeans(std::span<const float> values, uint32_t side) {
  double sum = 0.0;
  for (uint32_t y0 = 0; y0 < kNoiseSide; ++y0)
    for (uint32_t x0 = 0; x0 < kNoiseSide; ++x0) {
      double mean = 0.0;
      for (uint32_t y = y0; y < y0 + side; ++y)
        for (uint32_t x = x0; x < x0 + side; ++x) mean += values[y % kNoiseSide * kNoiseSide + x % kNoiseSide];
      sum += std::pow(mean / (side * side), 2);
    }
  return sum / values.size();
}

TEST(BlueNoise, HasEachValueOnceAndNoneNearItsLike) {
  const std::span<const float> noise = blueNoise();
  std::vector<float> sorted(noise.begin(), noise.end());
  std::ranges::sort(sorted);
  ASSERT_EQ(sorted.size(), size_t{kNoiseSide} * kNoiseSide);
  for (size_t i = 0; i < sorted.size(); ++i) EXPECT_EQ(sorted[i], (static_cast<float>(i) + 0.5f) / 4096.0f - 0.5f);
  std::vector<float> white = sorted;
  std::ranges::shuffle(white, std::mt19937(3));
  for (const auto& [side, share] : {std::pair(2u, 0.4), std::pair(3u, 0.3), std::pair(5u, 0.2), std::pair(8u, 0.12)})
    EXPECT_LT(varianceOfMeans(noise, side), share * varianceOfMeans(white, side)) << side;
}

Scene coarseScene(const char* name, float jitter) {
  Scene scene = smallScene(name, 64);
  scene.march.render.effects.jitter = jitter;
  return scene;
}

/// Of the picture's opacities, means of 5 x 5 pixels.
std::vector<double> smoothed(const Image<glm::vec4>& picture) {
  std::vector<double> means;
  for (uint32_t y = 0; y + 5 <= picture.height(); ++y)
    for (uint32_t x = 0; x + 5 <= picture.width(); ++x) {
      double sum = 0.0;
      for (uint32_t dy = 0; dy < 5; ++dy)
        for (uint32_t dx = 0; dx < 5; ++dx) sum += picture(x + dx, y + dy).a;
      means.push_back(sum / 25.0);
    }
  return means;
}

TEST(Jitter, MakesOfRingsWhatTheEyeAverages) {
  // Of marschner-lobb's error most is what steps of four voxels do to its waves, wherever they begin.
  for (const auto& [name, share] : {std::pair("shells", 0.7), std::pair("marschner-lobb", 0.9)}) {
    const auto pictureAt = [&](float step, float jitter) {
      Scene scene = coarseScene(name, jitter);
      scene.march.render.step = step;
      return smoothed(rendered(*makeCpuMarcher(scene.volume, scene.transferFunction), makeCamera(scene, scene.views.front(), 160, 160), scene.march));
    };
    const std::vector<double> truth = pictureAt(0.1f, 0.0f), rings = pictureAt(4.0f, 0.0f), noise = pictureAt(4.0f, 1.0f);
    const auto errorOf = [&](const std::vector<double>& picture) {
      double sum = 0.0;
      for (size_t i = 0; i < truth.size(); ++i) sum += std::pow(picture[i] - truth[i], 2);
      return std::sqrt(sum / static_cast<double>(truth.size()));
    };
    EXPECT_LT(errorOf(noise), share * errorOf(rings)) << name << ": " << errorOf(noise) << " and " << errorOf(rings);
  }
}

TEST(Jitter, SkippingAndEarlyEndsChangeNothing) {
  for (const char* name : {"shells", "vessels", "block"})
    for (const double distance : {1.0, 0.1}) {
      Scene scene = coarseScene(name, 1.0f);
      View view = scene.views.front();
      view.distance *= distance;
      const Camera camera = makeCamera(scene, view, 120, 90);
      const MarcherPtr marcher = makeCpuMarcher(scene.volume, scene.transferFunction);
      scene.march.render.terminateEarly = false;
      MarchSettings everything = scene.march;
      everything.render.skipEmpty = false;
      EXPECT_TRUE(sameBits(rendered(*marcher, camera, scene.march), rendered(*marcher, camera, everything))) << name << " at " << distance;
    }
}

TEST(Jitter, SamplesStayWithinHalfAStepOfWhereTheyWere) {
  // A box: what a ray sees of it is in one piece.
  const VolumePtr box = makeTestVolume(VoxelType::uint8, glm::uvec3(64), [](const glm::ivec3& p) {
    return glm::all(glm::greaterThan(p, glm::ivec3(15))) && glm::all(glm::lessThan(p, glm::ivec3(48))) ? 100.0 : 0.0;
  });
  const MarcherPtr marcher = makeCpuMarcher(box, band(50.0, 101.0, 1.0f));
  const Camera camera = lookingFrom({60.0f, 45.0f, 80.0f}, {}, 100, 100);
  MarchSettings settings;
  settings.render.step = 2.0f;
  settings.sample.heuristic = Heuristic::entrance;
  const SampleFrame before = marcher->march(camera, settings);
  settings.render.effects.jitter = 1.0f;
  const SampleFrame after = marcher->march(camera, settings);
  std::map<uint64_t, float> depths;
  for (const PackedSample sample : before.samples) depths[pixelKey(sample)] = decodeDepth(depthCode(sample), before.quantization.depthStep);
  size_t met = 0, near = 0;
  float farthest = 0.0f;
  for (const PackedSample sample : after.samples) {
    const auto there = depths.find(pixelKey(sample));
    if (there == depths.end()) continue;
    ++met;
    const float moved = std::abs(decodeDepth(depthCode(sample), after.quantization.depthStep) - there->second) - 4.0f * before.quantization.depthStep;
    near += moved <= 1.0f;
    farthest = std::max(farthest, moved);
  }
  EXPECT_GT(met, 1000u);
  EXPECT_GT(near, met * 2 / 3) << "where it is the same sample that is the first one inside";
  EXPECT_LE(farthest, 2.0f) << "elsewhere it is the one before it, or the one behind";
}

TEST(Jitter, FramesAreCodedAsWellAsOthers) {
  Scene scene = coarseScene("shells", 0.0f);
  const Camera camera = makeCamera(scene, scene.views.front(), 200, 200);
  const MarcherPtr marcher = makeCpuMarcher(scene.volume, scene.transferFunction);
  const SampleFrame before = marcher->march(camera, scene.march);
  scene.march.render.effects.jitter = 1.0f;
  const SampleFrame after = marcher->march(camera, scene.march);
  expectRoundTrips(after, "moved along their rays");
  EXPECT_NE(before.samples, after.samples);
  // Depths are places on lattices again; colours are noise, and take what noise takes.
  SampleFrame unknown = after;
  unknown.settings.render.effects.jitter = 0.0f;
  EXPECT_LT(bytesPerSample(after, kLossless), 0.8 * bytesPerSample(unknown, kLossless));
}

}  // namespace
}  // namespace warpscope
