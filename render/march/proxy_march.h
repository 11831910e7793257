// Pieces of rays through the coarse copy of a volume. For host and device.
// The march of march.h with the scalar source of the picture's mode; light comes from the copy's own gradients.
#pragma once

#include <limits>

#include "render/effects/clip.h"
#include "render/effects/isosurface.h"
#include "render/effects/mip.h"
#include "render/march/march.h"
#include "render/march/ray_state.h"
#include "render/march/volume_source_scalar.h"

namespace warpscope {

/// What a mode's source wants besides the view.
template <class Source>
struct ProxySetup {
  struct None {};
  using Type = None;
};
template <class Source>
  requires requires { typename Source::Setup; }
struct ProxySetup<Source> {
  using Type = typename Source::Setup;
};

using CompositeProxySource = ScalarVolumeSource<uint8_t, false, false>;
/// What is seen of a piece is the greatest value in it.
using MipProxySource = MipSource<uint8_t, false, false>;
/// Voxels of a copy are never missing: where the volume's are, surfaces end at the values about them.
using IsosurfaceProxySource = IsosurfaceSource<uint8_t, false, false>;

/// What all rays of a picture share. Plain data, by pointers to memory of where it is marched.
template <class Source, class Light>
struct ProxyMarch {
  using Setup = typename ProxySetup<Source>::Type;

  VolumeView<uint8_t> view;
  Setup setup;
  Light light;
  ClipSetup clip;  ///< its bounds are what is left of the copy's: no piece is longer than that, whatever a frame says of its own
  RayLimits limits;
  float step = 1.0f;
  bool isClipped = false;

  /// What the part [tNear, tFar] of the ray sends and lets through, behind what lets `through` pass: those of the whole ray's samples that lie in it; of surfaces, which lie between samples,
  /// those in it.
  WARPSCOPE_HD RayLight operator()(const Ray& ray, float tNear, float tFar, float through) const {
    constexpr bool kHasSurfaces = std::is_same_v<Source, IsosurfaceProxySource>;
    RayInterval interval = intersectBox(reciprocalOf(ray.origin, ray.direction), clip.bounds, kHasSurfaces ? tNear : 0.0f, kHasSurfaces ? tFar : std::numeric_limits<float>::infinity());
    if (interval.isMiss()) return {};
    if (isClipped) interval = clipped(clip, ray, interval);
    const RayPath path{ray, makeLattice(interval, step)};
    const int first = kHasSurfaces ? 0 : path.lattice.firstFrom(tNear), behind = kHasSurfaces ? path.lattice.count : path.lattice.firstFrom(tFar);
    if (!(first < behind)) return {};
    RayPiece piece{Transmittance(static_cast<double>(through))};
    const auto march = [&](auto&& source) {
      marchRay(path, first, behind, source, light, limits, piece, [](const CountingSample&) { return true; });
    };
    if constexpr (std::is_same_v<Source, CompositeProxySource>) {
      march(Source(view, path.ray, path.lattice));
    } else {
      const ModeView<uint8_t, Setup> ofMode{view, setup};
      march(Source(ofMode, path.ray, path.lattice));
    }
    return {piece.color(), piece.transmittance.alone().exact()};
  }
};

}  // namespace warpscope
