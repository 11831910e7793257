// By which way is the picture of a frame's spheres fastest: through a hierarchy, whose rays look for spheres, or by footprints, where each sphere looks for rays? The hierarchy is that of
// clusters on a device, lbvh on the CPU. The pictures are the same. Host only.
// Costs are sums of what each way does, as estimated from some of the spheres; the factors are fitted to measurements of sphere_ways_bench (tests/bench/README.md). That a hierarchy may have
// to be built first is left out: it stands for all pictures of a frame that follow.
#pragma once

#include <span>
#include <vector>

#include "render/core/camera.h"
#include "render/march/sample_frame.h"

namespace warpscope {

/// What the ways have to do for a picture.
struct SphereLoad {
  double pixels = 0.0;  ///< of the picture
  double spheres = 0.0;
  double fragments = 0.0;    ///< pixels in all spheres' footprints
  double tiles = 0.0;        ///< tiles of 8 x 8 pixels that footprints touch, in all
  double longestWalk = 0.0;  ///< pixels of the largest footprint, kPixelsOfWarp at most: the picture waits for its warp
};

/// Places of the samples that stand for all of so many; at most kMostSphereProbes.
std::vector<uint32_t> sphereProbes(size_t count);
inline constexpr size_t kMostSphereProbes = 512;

/// Estimates loads from spheres that stand for all of a frame's.
class SphereLoadProbe {
 public:
  SphereLoadProbe() = default;
  explicit SphereLoadProbe(const SampleFrame& frame);
  /// The same from those alone that stand for all `count` samples: the ones at sphereProbes(count), in order.
  SphereLoadProbe(size_t count, std::span<const PackedSample> probes, const SampleGrid& grid);

  /// For a camera that isUsable.
  SphereLoad loadFor(const Camera& camera) const;

 private:
  size_t count_ = 0;   // of the frame's spheres
  size_t probes_ = 0;  // of those that stand for all
  std::vector<float> x_, y_, z_, radius_;  // whole vectors of them
};

/// Milliseconds that a picture is expected to take each way, on the machine that this was fitted on: for comparing one with the other.
struct WayCosts {
  double footprints;
  double hierarchy;

  bool favourFootprints() const { return footprints <= hierarchy; }
};

/// Of `spheres` on a CUDA device.
WayCosts sphereCosts(const SphereLoad& load);
/// Whether footprints are the way for `spheres` on the CPU: nearly always, but where they are large (kLargeFootprint).
bool hostFavoursFootprints(const SphereLoad& load);
/// Pixels of a footprint in the mean over all spheres, from which on lbvh is faster on the CPU, or as fast: it need not look at all spheres of a pixel.
inline constexpr double kLargeFootprint = 4000.0;
/// Of `multihit` on a CUDA device, for so many surfaces a ray; fitted for 4, and scaled by the planes of hits that others keep.
WayCosts surfaceCosts(const SphereLoad& load, int surfaces);

}  // namespace warpscope
