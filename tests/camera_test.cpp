// Conventions of pixels, and what mirroring the basis does. Precision, impossible fields of view, points behind the eye: stability/camera_test.cpp.
// Mirrors render/core/camera.h.
#include "render/core/camera.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

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

}  // namespace
}  // namespace warpscope
