// Cameras and pictures for tests of marchers.
// A camera that looks from one place to another, and a bit-for-bit comparison of pictures.
#pragma once

#include <cstring>

#include "render/core/camera.h"
#include "render/core/image.h"
#include "render/march/marcher_cpu.h"

namespace warpscope {

inline Camera lookingFrom(const glm::vec3& eye, const glm::vec3& at, uint32_t width, uint32_t height, float tanHalfFovY = 0.4f) {
  Camera camera;
  camera.eye = eye;
  camera.forward = glm::normalize(at - eye);
  const glm::vec3 up = std::abs(camera.forward.y) > 0.9f ? glm::vec3(0.0f, 0.0f, 1.0f) : glm::vec3(0.0f, 1.0f, 0.0f);
  camera.right = glm::normalize(glm::cross(camera.forward, up));
  camera.up = glm::cross(camera.right, camera.forward);
  camera.tanHalfFovY = tanHalfFovY;
  camera.width = width;
  camera.height = height;
  return camera;
}

/// Opacity `alpha` over a unit, white, for every value.
inline TransferFunction everywhere(float alpha) { return {{{0.0, glm::vec3(1.0f), alpha}}}; }

/// Shows `from`..`to` and nothing else.
inline TransferFunction band(double from, double to, float alpha) {
  return {{{from, {1.0f, 0.3f, 0.1f}, 0.0f}, {from, {1.0f, 0.3f, 0.1f}, alpha}, {to, {0.1f, 0.3f, 1.0f}, alpha}, {to, glm::vec3(1.0f), 0.0f}}};
}

inline Image<glm::vec4> rendered(Marcher& marcher, const Camera& camera, const MarchSettings& settings = {}) {
  Image<glm::vec4> image;
  marcher.render(camera, settings.render, image);
  return image;
}

inline bool sameBits(const Image<glm::vec4>& a, const Image<glm::vec4>& b) {
  return a.width() == b.width() && a.height() == b.height() && std::memcmp(a.data(), b.data(), a.size() * sizeof(glm::vec4)) == 0;
}

inline bool sameFrame(const SampleFrame& a, const SampleFrame& b) {
  const bool haveSameSegments = a.segments.rays == b.segments.rays && a.segments.depths == b.segments.depths && a.segments.colors == b.segments.colors &&
                                a.segments.normals == b.segments.normals;
  return a.samples == b.samples && a.colors == b.colors && a.planes == b.planes && a.camera == b.camera && a.quantization == b.quantization && haveSameSegments;
}

/// Largest opacity in a picture; NaN if any component of it is not finite.
inline float largestAlpha(const Image<glm::vec4>& image) {
  float largest = 0.0f;
  for (const glm::vec4& pixel : image) {
    if (!std::isfinite(pixel.r + pixel.g + pixel.b + pixel.a)) return std::nanf("");
    largest = glm::max(largest, pixel.a);
  }
  return largest;
}

/// Length of a pixel's ray inside a box, in double.
inline double lengthInside(const Camera& camera, uint32_t x, uint32_t y, const Box& box) {
  const double edge = 2.0 * static_cast<double>(camera.tanHalfFovY) / camera.height;
  const glm::dvec3 direction = glm::normalize(glm::dvec3(camera.forward) + (x + 0.5 - 0.5 * camera.width) * edge * glm::dvec3(camera.right) +
                                              (0.5 * camera.height - y - 0.5) * edge * glm::dvec3(camera.up));
  double tNear = 0.0, tFar = 1e300;
  for (int axis = 0; axis < 3; ++axis) {
    const double lower = static_cast<double>(box.lower[axis]) - camera.eye[axis];
    const double upper = static_cast<double>(box.upper[axis]) - camera.eye[axis];
    if (std::abs(direction[axis]) < 1e-12) {
      if (lower > 0.0 || upper < 0.0) return 0.0;
      continue;
    }
    tNear = glm::max(tNear, glm::min(lower / direction[axis], upper / direction[axis]));
    tFar = glm::min(tFar, glm::max(lower / direction[axis], upper / direction[axis]));
  }
  return glm::max(0.0, tFar - tNear);
}

}  // namespace warpscope
