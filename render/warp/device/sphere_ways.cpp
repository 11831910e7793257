// Some spheres' footprints, and two sums of products.
// See sphere_ways.h.
#include "render/warp/device/sphere_ways.h"

#include <algorithm>

#include "render/warp/splats/sphere_footprint.h"

namespace warpscope {
namespace {

constexpr size_t kProbes = 512;
constexpr double kTileSide = 8.0;

}  // namespace

SphereLoadProbe::SphereLoadProbe(const SampleFrame& frame) : count_(frame.size()) {
  const size_t probes = std::min(count_, kProbes);
  const SampleGrid grid = frame.grid();
  for (size_t k = 0; k < probes; ++k) spheres_.push_back(unpackSample(frame.samples[(2 * k + 1) * count_ / (2 * probes)], grid));
}

SphereLoad SphereLoadProbe::loadFor(const Camera& camera) const {
  SphereLoad load;
  load.pixels = static_cast<double>(camera.width) * camera.height;
  load.spheres = static_cast<double>(count_);
  if (spheres_.empty()) return load;
  const FootprintView view = footprintViewOf(camera);
  const auto tilesOf = [](double pixels) { return 1.0 + (pixels - 1.0) / kTileSide; };  // in the mean over where they begin
  for (const Sphere& sphere : spheres_) {
    const PixelRect rect = sphereFootprint(view, sphere);
    if (rect.isEmpty()) continue;
    const double columns = rect.x1 - rect.x0, rows = rect.y1 - rect.y0;
    load.fragments += columns * rows;
    load.tiles += tilesOf(columns) * tilesOf(rows);
    load.longestWalk = std::max(load.longestWalk, columns * rows);
  }
  const double each = load.spheres / static_cast<double>(spheres_.size());
  load.fragments *= each;
  load.tiles *= each;
  load.longestWalk = std::min(load.longestWalk, static_cast<double>(kLargestWalk));
  return load;
}

// Milliseconds on an H100, by least squares of the logarithm's error over 832 pictures.
double footprintCost(const SphereLoad& load) { return 0.0256 + 2.10e-8 * load.pixels + 2.83e-9 * load.fragments + 3.73e-4 * load.longestWalk; }
double clusterCost(const SphereLoad& load) { return 0.0583 + 1.42e-7 * load.pixels + 1.04e-7 * load.spheres + 2.99e-8 * load.tiles; }

SphereTracing wayOf(const SphereLoad& load) { return footprintCost(load) <= clusterCost(load) ? SphereTracing::footprints : SphereTracing::clusters; }
SphereTracing surfaceWayOf(const SphereLoad& load) { return footprintCost(load) <= 2.5 * clusterCost(load) ? SphereTracing::footprints : SphereTracing::clusters; }

}  // namespace warpscope
