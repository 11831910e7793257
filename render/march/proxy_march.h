// Pieces of rays through the coarse copy of a volume. For host and device.
// The march of march.h with the scalar source; light comes from the copy's own gradients.
#pragma once

#include "render/effects/clip.h"
#include "render/march/march.h"
#include "render/march/ray_state.h"
#include "render/march/volume_source_scalar.h"

namespace warpscope {

/// What all rays of a picture share. Plain data, by pointers to memory of where it is marched.
template <class Light>
struct ProxyMarch {
  VolumeView<uint8_t> view;
  Light light;
  ClipSetup clip;
  RayLimits limits;
  Box bounds;  ///< of the copy: no piece is longer than that, whatever a frame says of its own
  float step = 1.0f;
  bool isClipped = false;

  /// What the part [tNear, tFar] of the ray sends and lets through, behind what lets `through` pass.
  WARPSCOPE_HD RayLight operator()(const Ray& ray, float tNear, float tFar, float through) const {
    RayInterval interval = intersectBox(reciprocalOf(ray.origin, ray.direction), bounds, tNear, tFar);
    if (interval.isMiss()) return {};
    if (isClipped) interval = clipped(clip, ray, interval);
    const RayPath path{ray, makeLattice(interval, step)};
    if (path.lattice.count == 0) return {};
    ScalarVolumeSource<uint8_t, false, false> source(view, path.ray, path.lattice);
    RayPiece piece{Transmittance(static_cast<double>(through))};
    marchRay(path, 0, path.lattice.count, source, light, limits, piece, [](const CountingSample&) { return true; });
    return {piece.color(), piece.transmittance.alone().exact()};
  }
};

}  // namespace warpscope
