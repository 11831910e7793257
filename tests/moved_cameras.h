// Cameras that were only turned, only moved, or see through another field of view, for tests of what depends on which.
#pragma once

#include <cmath>

#include "render/core/camera.h"

namespace warpscope {

/// About its own eye, to the right and up.
inline Camera turned(Camera camera, float rightDeg, float upDeg = 0.0f) {
  const auto mix = [](glm::vec3& forward, glm::vec3& aside, float degrees) {
    const float angle = glm::radians(degrees), c = std::cos(angle), s = std::sin(angle);
    const glm::vec3 before = forward;
    forward = glm::normalize(c * before + s * aside);
    aside = glm::normalize(c * aside - s * before);
  };
  mix(camera.forward, camera.right, rightDeg);
  mix(camera.forward, camera.up, upDeg);
  return camera;
}

inline Camera withEye(Camera camera, const glm::vec3& eye) {
  camera.eye = eye;
  return camera;
}

inline Camera ofSize(Camera camera, uint32_t width, uint32_t height) {
  camera.width = width;
  camera.height = height;
  return camera;
}

/// Half the field of view, about.
inline Camera zoomed(Camera camera) {
  camera.tanHalfFovY *= 0.5f;
  return camera;
}

}  // namespace warpscope
