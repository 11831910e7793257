// Clouds of spheres with cameras, for properties of what draws them. Everything shrinks: clouds to fewer spheres,
// cameras to smaller pictures. Shapes: tests/sphere_clouds.h; numbers of all magnitudes: magnitudes.h.
#pragma once

#include <algorithm>
#include <string_view>
#include <vector>

#include "tests/sphere_clouds.h"
#include "tests/stability/magnitudes.h"

namespace warpscope {

struct CloudCase {
  CloudShape shape;
  size_t count;
  float scale;
  uint32_t seed;
  Camera camera;

  std::vector<Sphere> cloud() const { return makeCloud(shape, count, scale, seed); }
};

/// From inside the cloud to far away, in images of up to `largest` whose sides are no multiple of a tile's; either
/// handedness.
inline rc::Gen<CloudCase> anyCloudCase(const glm::uvec2& largest = {50, 40}) {
  return rc::gen::map(rc::gen::tuple(rc::gen::elementOf(kCloudShapes), rc::gen::inRange<size_t>(1, 300),
                                     anyPositive(-13, 13), rc::gen::arbitrary<uint32_t>(), anyPositive(-3, 4),
                                     rc::gen::tuple(anyInteger(-180, 180), rc::gen::inRange(1u, largest.x + 1),
                                                    rc::gen::inRange(1u, largest.y + 1), rc::gen::arbitrary<bool>())),
                      [](const auto& parts) {
                        const auto& [shape, count, scale, seed, sizes, view] = parts;
                        const auto& [angleDeg, width, height, isLeftHanded] = view;
                        const float distance = scale * sizes;
                        Camera camera = orbitCamera(distance, static_cast<float>(angleDeg), width, height);
                        camera.tanHalfFovY = std::min(0.8f, 1.5f * scale / distance);
                        if (isLeftHanded) camera.right = -camera.right;
                        return CloudCase{shape, count, scale, seed, camera};
                      });
}

inline void showValue(const CloudCase& c, std::ostream& out) {
  constexpr std::array<std::string_view, kCloudShapes.size()> kNames{"random",    "planar",    "collinear",
                                                                     "clustered", "duplicate", "dense"};
  out << kNames[static_cast<size_t>(c.shape)] << ", " << c.count << " spheres of seed " << c.seed << ", scale "
      << std::hexfloat << c.scale << std::defaultfloat << "; camera: ";
  showValue(c.camera, out);
}

}  // namespace warpscope
