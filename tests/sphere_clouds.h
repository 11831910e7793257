// Clouds of spheres and cameras for tests and benchmarks of sphere tracing. Everything is determined by a seed.
// Shapes that hierarchies find hard: random, planar, collinear, clustered, duplicate, dense, and a frame's own samples.
#pragma once

#include <array>
#include <cmath>
#include <random>
#include <vector>

#include "render/core/camera.h"
#include "render/core/ray_sphere.h"
#include "render/core/sample.h"

namespace warpscope {

enum class CloudShape { random, planar, collinear, clustered, duplicate, dense };

inline constexpr std::array kCloudShapes{CloudShape::random, CloudShape::planar, CloudShape::collinear,
                                         CloudShape::clustered, CloudShape::duplicate, CloudShape::dense};

/// `count` spheres of radius about `scale / 50` (dense: a quarter of `scale`), within `scale` of the origin along every axis.
inline std::vector<Sphere> makeCloud(CloudShape shape, size_t count, float scale, uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> unit(-1.0f, 1.0f);
  std::vector<Sphere> cloud;
  for (size_t i = 0; i < count; ++i) {
    glm::vec3 center(unit(random), unit(random), unit(random));
    switch (shape) {
      case CloudShape::random:
        break;
      case CloudShape::planar:
        center.z = 0.25f;
        break;
      case CloudShape::collinear:
        center = glm::vec3(center.x, 0.5f * center.x, -0.25f * center.x);
        break;
      case CloudShape::clustered:
        center = glm::round(2.0f * center) * 0.5f + 0.02f * glm::vec3(unit(random), unit(random), unit(random));
        center = glm::clamp(center, -1.0f, 1.0f);
        break;
      case CloudShape::duplicate:
        center = glm::round(3.0f * center) / 3.0f;
        break;
      case CloudShape::dense:
        // A bumpy sheet, as a surface seen by pixels that are much smaller than voxels.
        center = {0.5f * center.x, 0.5f * center.y, 0.1f * std::sin(9.0f * center.x + 7.0f * center.y) + 0.01f * center.z};
        break;
    }
    float radius = shape == CloudShape::duplicate ? 0.05f : 0.02f * (1.0f + 0.5f * unit(random));
    if (shape == CloudShape::dense) radius = i % 100 == 99 ? 0.05f : 0.25f;  // one size, but for a few
    cloud.push_back({scale * center, scale * radius});
  }
  return cloud;
}

/// Enough for several blocks of a sort, with duplicates among them: ties have to be decided. Within 10 of the origin.
inline std::vector<Sphere> makeCloudOfTies() {
  auto cloud = makeCloud(CloudShape::duplicate, 100'000, 10.0f, 53);
  const auto more = makeCloud(CloudShape::clustered, 100'000, 10.0f, 54);
  cloud.insert(cloud.end(), more.begin(), more.end());
  return cloud;
}

/// A camera at `distance` from the origin, which it looks at, `angleDeg` about the vertical axis and 20 degrees above
/// the horizon.
inline Camera orbitCamera(float distance, float angleDeg, uint32_t width, uint32_t height) {
  const float azimuth = glm::radians(angleDeg), elevation = glm::radians(20.0f);
  Camera camera;
  camera.forward =
      -glm::vec3(std::sin(azimuth) * std::cos(elevation), std::sin(elevation), std::cos(azimuth) * std::cos(elevation));
  camera.eye = -distance * camera.forward;
  camera.right = glm::normalize(glm::cross(camera.forward, glm::vec3(0.0f, 1.0f, 0.0f)));
  camera.up = glm::cross(camera.right, camera.forward);
  camera.width = width;
  camera.height = height;
  return camera;
}

/// What a server sends: one sphere for each of `camera`'s pixels that meets a bumpy, noisy ball of radius 120 about the
/// origin (a volume of 256^3), with half a voxel's diagonal as radius.
inline std::vector<Sphere> makeFrameCloud(const Camera& camera, uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> noise(-0.5f, 0.5f);
  std::vector<Sphere> cloud;
  for (uint32_t y = 0; y < camera.height; ++y) {
    for (uint32_t x = 0; x < camera.width; ++x) {
      const Ray ray = pixelRay(camera, {x + 0.5f, y + 0.5f});
      const float t = intersectSphere(ray, glm::vec3(0.0f), 120.0f);
      if (t == kNoHit) continue;
      const glm::vec3 point = ray.at(t);
      const float bump = 6.0f * std::sin(0.2f * point.x) * std::sin(0.17f * point.y);
      cloud.push_back({ray.at(t + bump + noise(random)), 0.866f});
    }
  }
  return cloud;
}

}  // namespace warpscope
