// Cutting a volume: planes, a box, a slab across the view. A ray's part inside is found once, so that samples cost nothing. For host and device.
// A convex region's part of a ray, plane by plane: Cyrus, Beck 1978.
#pragma once

#include "render/core/box.h"
#include "render/core/camera.h"
#include "render/core/numeric.h"
#include "render/core/ray.h"
#include "render/effects/clip_settings.h"
#include "render/volume/volume.h"

namespace warpscope {

/// Kept is where dot(normal, p) >= offset, in volume space.
struct HalfSpace {
  glm::vec3 normal{0.0f};
  float offset = 0.0f;
};

/// What is the same for all rays of a picture.
struct ClipSetup {
  static constexpr int kMost = static_cast<int>(ClipPlanes::kMost) + 2;  ///< the slab has two

  Box bounds;  ///< of what is left of the volume's box
  int count = 0;
  HalfSpace planes[kMost];  ///< those that cut it
};

/// Planes that leave `bounds` whole are left out.
inline ClipSetup prepareClip(const Clip& clip, const Volume& volume, const Camera& camera) {
  ClipSetup setup;
  const Box& whole = volume.bounds();
  setup.bounds.lower = glm::mix(whole.lower, whole.upper, clip.box.lower);
  setup.bounds.upper = glm::mix(whole.lower, whole.upper, clip.box.upper);
  if (clip.box == ClipBox{}) setup.bounds = whole;
  const auto add = [&](const glm::dvec3& normal, double offset) {
    double least = INFINITY;
    for (int corner = 0; corner < 8; ++corner) {
      const glm::dvec3 place(corner & 1 ? whole.upper.x : whole.lower.x, corner & 2 ? whole.upper.y : whole.lower.y, corner & 4 ? whole.upper.z : whole.lower.z);
      least = glm::min(least, glm::dot(normal, place));
    }
    if (least < offset) setup.planes[setup.count++] = {glm::vec3(normal), static_cast<float>(offset)};
  };
  const VolumeGeometry& geometry = volume.geometry();
  for (const ClipPlane& plane : clip.planes)
    add(glm::normalize(glm::transpose(geometry.direction) * glm::dvec3(plane.normal)), double{plane.distance} / geometry.unit());
  if (clip.slab.thickness > 0.0f) {
    const glm::dvec3 forward(camera.forward);
    add(forward, double{clip.slab.depth} - 0.5 * double{clip.slab.thickness});
    add(-forward, -(double{clip.slab.depth} + 0.5 * double{clip.slab.thickness}));
  }
  return setup;
}

/// The part of a ray's interval that is kept, each end within two roundings of a dot product's terms over the ray's slope towards its plane.
WARPSCOPE_HD inline RayInterval clipped(const ClipSetup& setup, const Ray& ray, RayInterval interval) {
  for (int i = 0; i < setup.count; ++i) {
    const HalfSpace& plane = setup.planes[i];
    const float slope = mulAdd(plane.normal.z, ray.direction.z, mulAdd(plane.normal.y, ray.direction.y, plane.normal.x * ray.direction.x));
    const float height = mulAdd(plane.normal.z, ray.origin.z, mulAdd(plane.normal.y, ray.origin.y, plane.normal.x * ray.origin.x)) - plane.offset;
    if (absOf(slope) < 1e-12f) {  // along the plane
      if (height < 0.0f) interval = {};
      continue;
    }
    const float t = -height / slope;
    if (slope > 0.0f)
      interval.tNear = maxOf(t, interval.tNear);
    else
      interval.tFar = minOf(t, interval.tFar);
  }
  return interval;
}

}  // namespace warpscope
