// Rays and projection are each other's inverse, down to impossible fields of view and points behind the eye; rasterisers see the same.
// Mirrors render/core/camera.h; truth in double.
#include "render/core/camera.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <set>

#include "render/core/image.h"

namespace warpscope {
namespace {

/// Any direction, field of view, size, either handedness; the eye up to `farthest` from the origin.
Camera randomCamera(std::mt19937& random, float farthest) {
  std::uniform_real_distribution<float> unit(-1.0f, 1.0f);
  const auto vector = [&] { return glm::dvec3(unit(random), unit(random), unit(random)) + 1e-3; };
  const glm::dvec3 forward = glm::normalize(vector());
  const glm::dvec3 right = glm::normalize(glm::cross(forward, vector()));
  Camera camera;
  camera.eye = farthest * glm::vec3(unit(random), unit(random), unit(random));
  camera.forward = forward;
  camera.right = right;
  camera.up = glm::cross(right, forward);
  if (random() % 2) camera.right = -camera.right;  // mirrored
  camera.tanHalfFovY = std::exp2(5.0f * unit(random) - 2.0f);
  camera.width = 1 + random() % 4096;
  camera.height = 1 + random() % 4096;
  return camera;
}

RC_GTEST_PROP(Camera, ProjectionIsTheInverseOfPixelRays, (uint32_t seed)) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> unit(0.0f, 1.0f);
  for (int i = 0; i < 50; ++i) {
    const Camera camera = randomCamera(random, 100.0f);
    RC_ASSERT(isUsable(camera));
    const glm::vec2 pixel(unit(random) * camera.width, unit(random) * camera.height);
    const float t = std::exp2(12.0f * unit(random));
    const Ray ray = pixelRay(camera, pixel);
    RC_ASSERT(std::abs(glm::length(glm::dvec3(ray.direction)) - 1.0) < 3e-7);
    RC_ASSERT(ray.origin == camera.eye);
    const Projection back = project(camera, ray.at(t));
    const float cosine = glm::dot(ray.direction, camera.forward);
    RC_ASSERT(std::abs(back.forwardDepth - t * cosine) <= 2e-6f * (t + 100.0f));
    // Rounding of the point, seen in pixels; plus that of the pixel's own coordinates.
    const double errorPx = 4e-7 * (100.0 + t) / (t * cosine * cosine * pixelEdge(camera)) + 4e-6 * (camera.width + camera.height);
    RC_ASSERT(std::abs(back.pixel.x - pixel.x) <= errorPx);
    RC_ASSERT(std::abs(back.pixel.y - pixel.y) <= errorPx);
  }
}

TEST(Camera, ConventionsOfPixels) {
  Camera camera;
  camera.eye = {0.0f, 0.0f, 10.0f};
  camera.tanHalfFovY = 0.5f;
  camera.width = 40;
  camera.height = 20;
  EXPECT_EQ(pixelRay(camera, {20.0f, 10.0f}).direction, glm::vec3(0, 0, -1));  // the image's centre is straight ahead
  EXPECT_LT(pixelRay(camera, {0.5f, 10.0f}).direction.x, 0.0f);               // pixel 0 is at the left
  EXPECT_GT(pixelRay(camera, {20.0f, 0.5f}).direction.y, 0.0f);               // ... and at the top
  const glm::vec3 top = pixelRay(camera, {20.0f, 0.0f}).direction;            // the border is half the field of view away
  EXPECT_NEAR(top.y / -top.z, 0.5f, 1e-6f);
  EXPECT_FLOAT_EQ(pixelEdge(camera), 0.05f);
  const glm::vec2 place = project(camera, {2.0f, 1.0f, 0.0f}).pixel;
  EXPECT_NEAR(place.x, 20.0f + 2.0f / 0.5f, 1e-5f);
  EXPECT_NEAR(place.y, 10.0f - 1.0f / 0.5f, 1e-5f);
}

TEST(Camera, PointsAtOrBehindTheEyeAreNotInFront) {
  Camera camera;
  camera.width = camera.height = 8;
  EXPECT_LE(project(camera, camera.eye).forwardDepth, 0.0f);
  EXPECT_LE(project(camera, camera.eye + camera.right).forwardDepth, 0.0f);
  EXPECT_LT(project(camera, camera.eye - camera.forward).forwardDepth, 0.0f);
  EXPECT_GT(project(camera, camera.eye + 1e-3f * camera.forward).forwardDepth, 0.0f);
}

TEST(Camera, MirroringTheBasisMirrorsThePicture) {
  std::mt19937 random(48);
  std::uniform_real_distribution<float> unit(-1.0f, 1.0f);
  for (int i = 0; i < 100; ++i) {
    const Camera camera = randomCamera(random, 10.0f);
    Camera mirrored = camera;
    mirrored.right = -camera.right;
    ASSERT_TRUE(isUsable(mirrored));
    const glm::vec3 point = camera.eye + camera.forward * 5.0f + glm::vec3(unit(random), unit(random), unit(random));
    const Projection a = project(camera, point), b = project(mirrored, point);
    const float errorPx = 1e-5f * (camera.width + 1.0f / pixelEdge(camera));
    ASSERT_NEAR(a.pixel.x + b.pixel.x, camera.width, errorPx) << "seed 48, camera " << i;
    ASSERT_EQ(a.pixel.y, b.pixel.y);
    ASSERT_EQ(a.forwardDepth, b.forwardDepth);
  }
}

RC_GTEST_PROP(Camera, ClipCoordinatesAgreeWithProjection, (uint32_t seed)) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> unit(-1.0f, 1.0f);
  const Camera camera = randomCamera(random, 20.0f);
  const float nearDepth = 0.01f;
  const glm::mat4 clip = clipFromVolume(camera, nearDepth);
  for (int i = 0; i < 50; ++i) {
    const glm::vec3 point = camera.eye + 30.0f * camera.forward + 25.0f * glm::vec3(unit(random), unit(random), unit(random)) * 0.9f;
    const Projection truth = project(camera, point);
    const glm::vec4 place = clip * glm::vec4(point, 1.0f);
    if (truth.forwardDepth < 0.5f) continue;
    RC_ASSERT(std::abs(place.w - truth.forwardDepth) < 3e-5f);
    const double errorPx = 2e-4 / (truth.forwardDepth * pixelEdge(camera)) + 1e-5 * (camera.width + camera.height) *
                           (1.0 + glm::length(truth.pixel) / camera.height) ;
    RC_ASSERT(std::abs((place.x / place.w * 0.5f + 0.5f) * camera.width - truth.pixel.x) < errorPx);
    RC_ASSERT(std::abs((0.5f - place.y / place.w * 0.5f) * camera.height - truth.pixel.y) < errorPx);
    RC_ASSERT(std::abs(place.z / place.w - nearDepth / truth.forwardDepth) < 1e-4f * nearDepth / truth.forwardDepth);
  }
}

TEST(Camera, ReverseDepthTellsAThousandStepsApartAtDepthAThousand) {
  Camera camera;
  camera.eye = glm::vec3(0.0f);
  camera.width = camera.height = 1;
  const glm::mat4 clip = clipFromVolume(camera, 1e-3f);
  std::set<float> depths;
  float before = 2.0f;
  for (int i = 0; i < 1000; ++i) {
    const glm::vec4 place = clip * glm::vec4(0.0f, 0.0f, -(1000.0f + static_cast<float>(i) * 1e-3f), 1.0f);
    const float depth = place.z / place.w;
    EXPECT_LT(depth, before);  // farther is less
    before = depth;
    depths.insert(depth);
  }
  EXPECT_EQ(depths.size(), 1000u);
  const auto depthAt = [&](float z) {
    const glm::vec4 place = clip * glm::vec4(0.0f, 0.0f, -z, 1.0f);
    return place.z / place.w;
  };
  EXPECT_FLOAT_EQ(depthAt(1e-3f), 1.0f);
  EXPECT_GT(depthAt(1e5f), 0.0f);
  EXPECT_GT(depthAt(99999.0f), depthAt(1e5f));
}

TEST(Camera, RefusesWhatCannotMakePictures) {
  Camera good;
  good.width = 64;
  good.height = 48;
  EXPECT_TRUE(isUsable(good));
  const float nan = std::nanf(""), inf = std::numeric_limits<float>::infinity();
  const auto refuses = [&](auto change) {
    Camera bad = good;
    change(bad);
    return !isUsable(bad);
  };
  for (const float wrong : {nan, inf, -inf})
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_TRUE(refuses([&](Camera& c) { c.eye[axis] = wrong; }));
      EXPECT_TRUE(refuses([&](Camera& c) { c.right[axis] = wrong; }));
      EXPECT_TRUE(refuses([&](Camera& c) { c.up[axis] = wrong; }));
      EXPECT_TRUE(refuses([&](Camera& c) { c.forward[axis] = wrong; }));
    }
  for (const float wrong : {nan, inf, 0.0f, -0.4f, 1e8f}) EXPECT_TRUE(refuses([&](Camera& c) { c.tanHalfFovY = wrong; })) << wrong;
  EXPECT_TRUE(refuses([](Camera& c) { c.width = 0; }));
  EXPECT_TRUE(refuses([](Camera& c) { c.height = 0; }));
  EXPECT_TRUE(refuses([](Camera& c) { c.width = kMaxImageSide + 1; }));
  EXPECT_TRUE(refuses([](Camera& c) { c.height = 0xffffffffu; }));
  EXPECT_FALSE(refuses([](Camera& c) { c.width = c.height = kMaxImageSide; }));
  EXPECT_TRUE(refuses([](Camera& c) { c.forward = glm::vec3(0.0f); }));
  EXPECT_TRUE(refuses([](Camera& c) { c.forward *= 2.0f; }));
  EXPECT_TRUE(refuses([](Camera& c) { c.forward = c.up; }));
  EXPECT_TRUE(refuses([](Camera& c) { c.right = c.up; }));
  EXPECT_FALSE(refuses([](Camera& c) { c.right = -c.right; }));  // mirrored is usable
}

}  // namespace
}  // namespace warpscope
