// By which way is the picture of a frame's spheres fastest on a device: through the hierarchy of clusters, whose rays look for spheres, or by footprints, where each sphere looks for
// rays? The pictures are the same. Host only.
// Costs are linear in what each way does, as estimated from some of the spheres; the factors are fitted to measurements of sphere_ways_bench (tests/bench/README.md). That clusters may have
// to be built first is left out: they stand for all pictures of a frame that follow.
#pragma once

#include <vector>

#include "render/core/camera.h"
#include "render/march/sample_frame.h"
#include "render/warp/spheres_warp.h"

namespace warpscope {

/// What the ways have to do for a picture.
struct SphereLoad {
  double pixels = 0.0;  ///< of the picture
  double spheres = 0.0;
  double fragments = 0.0;    ///< pixels in all spheres' footprints
  double tiles = 0.0;        ///< tiles of 8 x 8 pixels that footprints touch, in all
  double longestWalk = 0.0;  ///< pixels of the largest footprint, kPixelsOfWarp at most: the picture waits for the warp that walks it
};

/// Estimates loads from spheres that stand for all of a frame's.
class SphereLoadProbe {
 public:
  SphereLoadProbe() = default;
  explicit SphereLoadProbe(const SampleFrame& frame);

  /// For a camera that isUsable.
  SphereLoad loadFor(const Camera& camera) const;

 private:
  size_t count_ = 0;   // of the frame's spheres
  size_t probes_ = 0;  // of those that stand for all
  std::vector<float> x_, y_, z_, radius_;  // whole vectors of them
};

/// Milliseconds that a picture is expected to take each way, on the device that this was fitted on: for comparing one with the other.
struct WayCosts {
  double footprints;
  double clusters;

  /// SphereTracing::footprints or clusters.
  SphereTracing fastest() const { return footprints <= clusters ? SphereTracing::footprints : SphereTracing::clusters; }
};

/// Of `spheres`.
WayCosts sphereCosts(const SphereLoad& load);
/// Of `multihit`, for so many surfaces a ray; fitted for 4, and scaled by the planes of hits that others keep.
WayCosts surfaceCosts(const SphereLoad& load, int surfaces);

}  // namespace warpscope
