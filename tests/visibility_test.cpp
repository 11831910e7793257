// What a frame knew of another view: a wall behind a block, and marched volumes, seen from the same place and from others.
// Mirrors render/metrics/visibility.h.
#include "render/metrics/visibility.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>

#include "render/base/error.h"
#include "render/march/marcher_cpu.h"
#include "tests/frame_samples.h"
#include "test_volumes.h"

namespace warpscope {
namespace {

/// Distance at which a ray meets something, if it does.
using Surface = std::function<std::optional<float>(const Ray&)>;

enum class Part { nothing, wall, block };

/// What a ray meets first, and where: a wall in the plane z = -10, 60 wide and high, or a block's front, 8 wide and high, in the plane z = 10.
Part partAt(const Ray& ray, float& t) {
  const auto reach = [&](float z, float halfEdge) {
    t = (z - ray.origin.z) / ray.direction.z;
    const glm::vec3 p = ray.at(t);
    return t > 0.0f && std::abs(p.x) <= halfEdge && std::abs(p.y) <= halfEdge;
  };
  if (reach(10.0f, 4.0f)) return Part::block;
  if (reach(-10.0f, 30.0f)) return Part::wall;
  return Part::nothing;
}

/// Looks at the origin from `distance`, turned about the vertical axis.
Camera lookingAt(float angleDeg, uint32_t width, uint32_t height, float distance = 60.0f) {
  const float angle = glm::radians(angleDeg);
  Camera camera;
  camera.forward = {-std::sin(angle), 0.0f, -std::cos(angle)};
  camera.right = {std::cos(angle), 0.0f, -std::sin(angle)};
  camera.eye = -distance * camera.forward;
  camera.tanHalfFovY = 0.4f;
  camera.width = width;
  camera.height = height;
  return camera;
}

SampleFrame frameOf(const Camera& camera, const Surface& surface) {
  SampleFrame frame;
  frame.camera = camera;
  frame.quantization = {{glm::vec3(-40.0f), glm::vec3(40.0f)}, 1.0f, 0.0f, 0x1p-11f};
  frame.voxelRadius = 0.5f * std::sqrt(3.0f);
  for (uint32_t y = 0; y < camera.height; ++y)
    for (uint32_t x = 0; x < camera.width; ++x) {
      const Ray ray = pixelRay(camera, {x + 0.5f, y + 0.5f});
      const std::optional<float> t = surface(ray);
      if (!t) continue;
      frame.samples.push_back(sampleOnRay(frame, y * camera.width + x, *t, frame.voxelRadius));
      frame.colors.push_back(~0u);
    }
  return frame;
}

SampleFrame blockAndWall(const Camera& camera) {
  return frameOf(camera, [](const Ray& ray) -> std::optional<float> {
    float t = 0.0f;
    return partAt(ray, t) == Part::nothing ? std::nullopt : std::optional(t);
  });
}

size_t count(const Image<Visibility>& mask, Visibility kind) { return static_cast<size_t>(std::count(mask.begin(), mask.end(), kind)); }

/// What is truly seen from `server`, by a ray to the point; nothing where the answer is within `margin` of the block's outline or of the
/// image's border.
std::optional<bool> truth(const glm::vec3& point, Part part, const Camera& server, float margin) {
  const Projection seen = project(server, point);
  const glm::vec2 inside = glm::min(seen.pixel, glm::vec2(server.width, server.height) - seen.pixel);
  const float fromBorder = std::min(inside.x, inside.y);
  if (std::abs(fromBorder) < 1e-2f) return std::nullopt;
  if (fromBorder < 0.0f) return false;
  if (part == Part::block) return true;
  const Ray ray{server.eye, glm::normalize(point - server.eye)};
  const glm::vec3 atBlock = ray.at((10.0f - ray.origin.z) / ray.direction.z);
  const float outside = std::max(std::abs(atBlock.x), std::abs(atBlock.y)) - 4.0f;
  if (std::abs(outside) < margin) return std::nullopt;
  return outside > 0.0f;
}

void expectTruth(const Camera& server, const Camera& now, size_t leastDisoccluded) {
  const Image<Visibility> mask = visibilityOf(blockAndWall(server), blockAndWall(now));
  ASSERT_EQ(mask.width(), now.width);
  ASSERT_EQ(mask.height(), now.height);
  // Near the outline the frame's neighbouring pixels answer: a tolerance and two pixels' diagonals.
  const float margin = 2.0f * 0.87f + 4.0f * pixelEdge(server) * 80.0f;
  size_t disoccluded = 0;
  for (uint32_t y = 0; y < now.height; ++y)
    for (uint32_t x = 0; x < now.width; ++x) {
      const Ray ray = pixelRay(now, {x + 0.5f, y + 0.5f});
      float t = 0.0f;
      const Part part = partAt(ray, t);
      if (part == Part::nothing) {
        ASSERT_EQ(mask(x, y), Visibility::empty) << x << " " << y;
        continue;
      }
      ASSERT_NE(mask(x, y), Visibility::empty) << x << " " << y;
      const std::optional<bool> isSeen = truth(ray.at(t), part, server, margin);
      if (!isSeen) continue;
      ASSERT_EQ(mask(x, y), *isSeen ? Visibility::visible : Visibility::disoccluded) << x << " " << y;
      disoccluded += !*isSeen;
    }
  EXPECT_GE(disoccluded, leastDisoccluded);
}

TEST(Visibility, TheSameViewHidesNothing) {
  const SampleFrame frame = blockAndWall(lookingAt(0.0f, 120, 90));
  const Image<Visibility> mask = visibilityOf(frame, frame);
  EXPECT_EQ(count(mask, Visibility::disoccluded), 0u);
  EXPECT_EQ(count(mask, Visibility::visible), frame.size());
  EXPECT_GT(frame.size(), 5000u);
}

TEST(Visibility, TheSameViewHidesNothingWhateverTheSizes) {
  for (const uint32_t height : {30u, 57u, 180u, 400u}) {
    const Image<Visibility> mask = visibilityOf(blockAndWall(lookingAt(0.0f, 120, 90)), blockAndWall(lookingAt(0.0f, height * 4 / 3, height)));
    EXPECT_EQ(mask.height(), height);
    EXPECT_GT(count(mask, Visibility::visible), 0u);
    // Rays between those of the frame may pass the block where these do not: pixels along its outline only.
    EXPECT_LE(count(mask, Visibility::disoccluded), 4u * height);
  }
}

TEST(Visibility, TheWallBehindTheBlockIsDisoccludedAfterTurning) {
  expectTruth(lookingAt(0.0f, 240, 240), lookingAt(20.0f, 240, 240), 500);
  expectTruth(lookingAt(0.0f, 240, 240), lookingAt(-35.0f, 160, 240), 500);
  expectTruth(lookingAt(15.0f, 200, 300), lookingAt(-15.0f, 300, 200), 500);
}

TEST(Visibility, WhatLiesOutsideTheFramesImageIsDisoccluded) {
  // Nearer: the frame's image ends within the wall.
  expectTruth(lookingAt(0.0f, 200, 200, 40.0f), lookingAt(0.0f, 200, 200, 90.0f), 1000);
}

TEST(Visibility, WhatLiesBehindTheFramesEyeIsDisoccluded) {
  Camera away = lookingAt(0.0f, 50, 50);
  away.eye = {0.0f, 0.0f, -20.0f};  // behind the wall, looking away from it
  const SampleFrame here = blockAndWall(lookingAt(0.0f, 50, 50));
  SampleFrame there = here;
  there.camera = away;
  there.samples.clear();
  there.colors.clear();
  EXPECT_EQ(count(visibilityOf(there, here), Visibility::disoccluded), here.size());
  there.camera = here.camera;  // nothing was found where something is
  EXPECT_EQ(count(visibilityOf(there, here), Visibility::disoccluded), here.size());
  EXPECT_EQ(count(visibilityOf(here, there), Visibility::empty), 2500u);
}

TEST(Visibility, AMarchedVolumeIsKnownFromItsOwnViewAndLessFromOthers) {
  const glm::uvec3 dims(40);
  const VolumePtr volume = makeTestVolume(VoxelType::uint8, dims, blobs(dims, 7));
  const MarcherPtr marcher = makeCpuMarcher(volume, TransferFunction{{{20.0, glm::vec3(1.0f), 0.0f}, {60.0, glm::vec3(1.0f), 0.6f}}});
  MarchSettings settings;
  settings.sample.heuristic = Heuristic::gradient;
  const SampleFrame front = marcher->march(lookingAt(0.0f, 160, 160), settings);
  ASSERT_GT(front.size(), 2000u);
  EXPECT_EQ(count(visibilityOf(front, front), Visibility::disoccluded), 0u);
  size_t before = 0;
  for (const float angle : {5.0f, 30.0f, 90.0f}) {
    const SampleFrame turned = marcher->march(lookingAt(angle, 160, 160), settings);
    const Image<Visibility> mask = visibilityOf(front, turned);
    EXPECT_EQ(count(mask, Visibility::empty), mask.size() - turned.size());
    EXPECT_GT(count(mask, Visibility::disoccluded), before);
    EXPECT_GT(count(mask, Visibility::visible), turned.size() / 20);
    before = count(mask, Visibility::disoccluded);
  }
}

TEST(Visibility, AnUnusableCameraIsRefused) {
  const SampleFrame good = blockAndWall(lookingAt(0.0f, 20, 20));
  SampleFrame bad = good;
  bad.camera.width = 0;
  EXPECT_THROW(visibilityOf(good, bad), InputError);
  EXPECT_THROW(visibilityOf(bad, good), InputError);
}

}  // namespace
}  // namespace warpscope
