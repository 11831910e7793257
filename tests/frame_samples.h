// Cameras and samples of frames that tests make up: on pixels' rays, and clouds of spheres that no marcher has seen.
#pragma once

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "render/march/sample_frame.h"

namespace warpscope {

inline Sphere sphereOf(const SampleFrame& frame, size_t i) { return unpackSample(frame.samples.at(i), frame.grid()); }

/// The sample on the ray of a pixel (row times width plus column), at a distance from the frame's eye.
inline PackedSample sampleOnRay(const SampleFrame& frame, uint32_t pixel, float distance, float radius) {
  const uint32_t column = pixel % frame.camera.width, row = pixel / frame.camera.width;
  const PixelGrid grid = makePixelGrid(frame.camera, 0.0f);
  return packSample(column, row, distance * grid.ray(column, row).cosine - frame.quantization.nearDepth, radius, frame.quantization);
}

/// A camera at `z`, looking along -z.
inline Camera frontCamera(uint32_t width, uint32_t height, float z = 10.0f) {
  Camera camera;
  camera.eye = {0.0f, 0.0f, z};
  camera.width = width;
  camera.height = height;
  return camera;
}

/// A frame of spheres as a camera on the z axis sees them, `distance` in front of the origin: each in the nearest of its pixels, which are
/// `cell` wide there, and at the nearest depth. Those in the plane z = 0 on the grid of cells, or at x = y = 0 and z a multiple of 1/4096, are
/// kept exactly if all are powers of two. `side` is odd. Colours are 0: they are for the caller.
inline SampleFrame frameOfSpheres(const std::vector<Sphere>& spheres, float radiusUnit, float cell, uint32_t side, float distance) {
  SampleFrame frame;
  frame.camera.eye = {0.0f, 0.0f, distance};
  frame.camera.width = frame.camera.height = side;
  frame.camera.tanHalfFovY = 0.5f * static_cast<float>(side) * cell / distance;
  frame.quantization.radiusUnit = radiusUnit;
  frame.quantization.depthStep = distance * 0x1p-20f;
  const float middle = 0.5f * static_cast<float>(side - 1);
  const auto at = [&](float cells) { return static_cast<uint32_t>(std::lround(std::clamp(middle + cells, 0.0f, 2.0f * middle))); };
  for (const Sphere& sphere : spheres) {
    frame.quantization.bounds.include(sphere.center);
    const float behind = distance - sphere.center.z, atPlane = distance / (behind * cell);
    frame.samples.push_back(packSample(at(sphere.center.x * atPlane), at(-sphere.center.y * atPlane), behind, sphere.radius, frame.quantization));
  }
  if (spheres.empty()) frame.quantization.bounds = {glm::vec3(-1.0f), glm::vec3(1.0f)};
  frame.colors.resize(spheres.size());
  return frame;
}

/// The same with as many pixels as there can be: centres within about 2^-13 of the cloud's extent from what they were.
inline SampleFrame frameOfCloud(const std::vector<Sphere>& cloud) {
  float reach = 0x1p-20f, radius = 0.0f;
  for (const Sphere& sphere : cloud) {
    reach = std::max({reach, std::abs(sphere.center.x), std::abs(sphere.center.y), std::abs(sphere.center.z)});
    radius = std::max(radius, sphere.radius);
  }
  const float distance = std::exp2(std::ceil(std::log2(reach)) + 2.0f);
  return frameOfSpheres(cloud, radiusUnitFor(radius), distance * 0x1p-14f, 16383, distance);
}

}  // namespace warpscope
