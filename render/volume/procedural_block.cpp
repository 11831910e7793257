// A machined part: constructive solid geometry on signed distances, one material and a bushing of another.
// Distances after Hart 1996, "Sphere Tracing"; only their signs and their values near the surface are used.
#include "render/volume/procedural_fields.h"

namespace warpscope::procedural {
namespace {

// The part's space: 2.75 x 2 x 2 units fill the default 176 x 128 x 128 voxels; y is up.
constexpr glm::vec3 kSize{2.75f, 2.0f, 2.0f};
constexpr float kBodyValue = 255.0f;
constexpr float kBushingValue = 150.0f;

// A brick whose middle lies further than this from both surfaces (in voxels: half its diagonal, half a voxel of edge,
// rounding) has one value throughout, because none of the distances changes faster than the position does.
constexpr uint32_t kBrickSide = 8;
constexpr float kBrickReach = 7.6f;

float cut(float solid, float tool) { return glm::max(solid, -tool); }
float join(float a, float b) { return glm::min(a, b); }

float box(const glm::vec3& p, const glm::vec3& center, const glm::vec3& half) {
  const glm::vec3 q = glm::abs(p - center) - half;
  return glm::length(glm::max(q, glm::vec3(0.0f))) + glm::min(glm::max(q.x, glm::max(q.y, q.z)), 0.0f);
}

/// A box whose twelve edges are cut at 45 degrees.
float chamferedBox(const glm::vec3& p, const glm::vec3& half, float chamfer) {
  const glm::vec3 q = glm::abs(p);
  const glm::vec3 sums(q.x + q.y - half.x - half.y, q.y + q.z - half.y - half.z, q.z + q.x - half.z - half.x);
  const float edges = (glm::max(sums.x, glm::max(sums.y, sums.z)) + chamfer) * 0.70710678f;
  return glm::max(box(p, glm::vec3(0.0f), half), edges);
}

/// A cylinder along `axis` (0 x, 1 y, 2 z) from `from` to `to`; `center` gives its other two coordinates.
float cylinder(const glm::vec3& p, int axis, const glm::vec3& center, float radius, float from, float to) {
  glm::vec3 q = p - center;
  q[axis] = 0.0f;
  return glm::max(glm::length(q) - radius, glm::max(from - p[axis], p[axis] - to));
}

struct Distances {
  float body, bushing;
};

Distances distances(const glm::vec3& p) {
  // Body: a block on a flange, with a round boss on top.
  float body = chamferedBox(p - glm::vec3(0.0f, -0.10f, 0.0f), {1.02f, 0.58f, 0.72f}, 0.10f);
  body = join(body, chamferedBox(p - glm::vec3(0.0f, -0.70f, 0.0f), {1.28f, 0.16f, 0.90f}, 0.06f));
  body = join(body, cylinder(p, 1, {-0.34f, 0.0f, 0.0f}, 0.46f, 0.0f, 0.86f));

  // Main bore through the boss, counterbored from above; its bushing stands a little proud of the counterbore's floor.
  const glm::vec3 mainAxis(-0.34f, 0.0f, 0.0f);
  body = cut(body, cylinder(p, 1, mainAxis, 0.26f, -1.0f, 1.0f));
  body = cut(body, cylinder(p, 1, mainAxis, 0.35f, 0.66f, 1.0f));
  float bushing = cylinder(p, 1, mainAxis, 0.26f, -0.30f, 0.72f);
  bushing = cut(bushing, cylinder(p, 1, mainAxis, 0.18f, -1.0f, 1.0f));

  // Cross bores, which meet the main one, and a slot beside the boss.
  body = cut(body, cylinder(p, 0, {0.0f, -0.42f, 0.0f}, 0.13f, -2.0f, 2.0f));
  body = cut(body, cylinder(p, 2, {0.55f, -0.18f, 0.0f}, 0.20f, -2.0f, 2.0f));
  body = cut(body, box(p, {0.62f, 0.42f, 0.0f}, {0.30f, 0.22f, 0.17f}));
  body = cut(body, cylinder(p, 2, {0.0f, 0.16f, 0.0f}, 0.06f, -2.0f, -0.30f));

  // Four fixing holes in the flange, countersunk by a wider step.
  const glm::vec3 mirrored(std::abs(p.x), p.y, std::abs(p.z));
  body = cut(body, cylinder(mirrored, 1, {1.13f, 0.0f, 0.74f}, 0.065f, -2.0f, 0.0f));
  body = cut(body, cylinder(mirrored, 1, {1.13f, 0.0f, 0.74f}, 0.105f, -0.60f, 0.0f));
  return {body, bushing};
}

}  // namespace

void fillBlock(uint8_t* voxels, const Wanted& wanted, const std::stop_token& stop) {
  const glm::uvec3& dims = wanted.dims;
  // One scale for all axes: a bore stays round whatever the size.
  const glm::vec3 fit = glm::vec3(dims) / kSize;
  const float voxelsPerUnit = glm::min(fit.x, glm::min(fit.y, fit.z));
  const auto pointAt = [&](const glm::vec3& voxel) { return (voxel + 0.5f - 0.5f * glm::vec3(dims)) / voxelsPerUnit; };
  fillBricks(kBrickSide, wanted, 16, stop, [&](const glm::uvec3& brick, const glm::uvec3& lower, const glm::uvec3& upper) {
    const Distances middle = distances(pointAt(glm::vec3(brick * kBrickSide) + 0.5f * (kBrickSide - 1.0f)));
    const bool isUniform =
        std::abs(middle.body) * voxelsPerUnit > kBrickReach && std::abs(middle.bushing) * voxelsPerUnit > kBrickReach;
    for (uint32_t z = lower.z; z < upper.z; ++z)
      for (uint32_t y = lower.y; y < upper.y; ++y)
        for (uint32_t x = lower.x; x < upper.x; ++x) {
          const Distances d = isUniform ? middle : distances(pointAt(glm::vec3(x, y, z)));
          // How much of the voxel each material fills, as if its surface were flat there.
          const float body = glm::clamp(0.5f - d.body * voxelsPerUnit, 0.0f, 1.0f);
          const float bushing = glm::min(glm::clamp(0.5f - d.bushing * voxelsPerUnit, 0.0f, 1.0f), 1.0f - body);
          voxels[(size_t{z} * dims.y + y) * dims.x + x] = quantize(kBodyValue * body + kBushingValue * bushing);
        }
  });
}

}  // namespace warpscope::procedural
