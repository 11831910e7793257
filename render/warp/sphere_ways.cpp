// Some spheres' footprints, and two sums of products.
// See sphere_ways.h.
#include "render/warp/sphere_ways.h"

#include <algorithm>
#include <cmath>

#include "render/core/simd.h"
#include "render/warp/multihit/surface_hits.h"
#include "render/warp/splats/footprint_limits.h"
#include "render/warp/splats/sphere_footprint.h"

namespace warpscope {
namespace {

constexpr float kTileSide = 8.0f;

}  // namespace

std::vector<uint32_t> sphereProbes(size_t count) {
  const size_t probes = std::min(count, kMostSphereProbes);
  std::vector<uint32_t> places(probes);
  for (size_t k = 0; k < probes; ++k) {
    // Each from its share of the frame, at another place of it: samples are in the order of the picture's pixels, and even steps would come upon one column again and again.
    const double within = 0.6180339887 * static_cast<double>(k);
    const double place = (static_cast<double>(k) + within - std::floor(within)) * static_cast<double>(count) / static_cast<double>(probes);
    places[k] = static_cast<uint32_t>(std::min(count - 1, count == probes ? k : static_cast<size_t>(place)));
  }
  return places;
}

SphereLoadProbe::SphereLoadProbe(const SampleFrame& frame) {
  std::vector<PackedSample> probes;
  for (const uint32_t place : sphereProbes(frame.size())) probes.push_back(frame.samples[place]);
  *this = SphereLoadProbe(frame.size(), probes, frame.grid());
}

SphereLoadProbe::SphereLoadProbe(size_t count, std::span<const PackedSample> probes, const SampleGrid& grid) : count_(count), probes_(probes.size()) {
  const size_t whole = (probes_ + kBatchLanes - 1) / kBatchLanes * kBatchLanes;
  for (std::vector<float>* part : {&x_, &y_, &z_, &radius_}) part->resize(whole);  // spheres without a radius cover nothing
  for (size_t k = 0; k < probes_; ++k) {
    const Sphere sphere = unpackSample(probes[k], grid);
    x_[k] = sphere.center.x;
    y_[k] = sphere.center.y;
    z_[k] = sphere.center.z;
    radius_[k] = sphere.radius;
  }
}

SphereLoad SphereLoadProbe::loadFor(const Camera& camera) const {
  SphereLoad load;
  load.pixels = static_cast<double>(camera.width) * camera.height;
  load.spheres = static_cast<double>(count_);
  if (probes_ == 0) return load;
  const FootprintView view = footprintViewOf(camera);
  const auto tilesOf = [](float pixels) { return 1.0f + (pixels - 1.0f) / kTileSide; };  // in the mean over where they begin
  for (size_t first = 0; first < x_.size(); first += kBatchLanes) {
    const auto part = [&](const std::vector<float>& values, float eye) { return FloatBatch::load_unaligned(values.data() + first) - FloatBatch(eye); };
    const auto bounds = footprint::boundsOf(view, part(x_, view.eye.x), part(y_, view.eye.y), part(z_, view.eye.z), part(radius_, 0.0f));
    alignas(64) int32_t x0[kBatchLanes], y0[kBatchLanes], x1[kBatchLanes], y1[kBatchLanes];
    bounds.x0.store_aligned(x0);
    bounds.y0.store_aligned(y0);
    bounds.x1.store_aligned(x1);
    bounds.y1.store_aligned(y1);
    for (int i = 0; i < kBatchLanes; ++i) {
      if (x0[i] >= x1[i] || y0[i] >= y1[i]) continue;
      const auto columns = static_cast<float>(x1[i] - x0[i]), rows = static_cast<float>(y1[i] - y0[i]);
      load.fragments += columns * rows;
      load.tiles += tilesOf(columns) * tilesOf(rows);
      load.longestWalk = std::max<double>(load.longestWalk, columns * rows);
    }
  }
  const double each = load.spheres / static_cast<double>(probes_);
  load.fragments *= each;
  load.tiles *= each;
  load.longestWalk = std::min(load.longestWalk, static_cast<double>(kPixelsOfWarp));
  return load;
}

// Milliseconds on an H200, over 916 views of each technique. Factors have the least mean of how much longer, as a logarithm, the chosen way takes than the faster one, and a fiftieth of the squared
// errors of both ways' logarithms.
WayCosts sphereCosts(const SphereLoad& load) {
  const double beside = std::min(load.spheres, load.pixels);  // there was no view with more spheres than pixels
  return {0.0219 + 1.71e-8 * load.pixels + 2.84e-9 * load.fragments + 3.62e-4 * load.longestWalk,
          0.0560 + 6.72e-8 * load.pixels + 3.45e-7 * beside + 2.58e-8 * load.tiles};
}

bool hostFavoursFootprints(const SphereLoad& load) { return load.fragments <= kLargeFootprint * load.spheres; }

WayCosts surfaceCosts(const SphereLoad& load, int surfaces) {
  const double planes = (piecesFor(surfaces) + 1) / (piecesFor(4) + 1.0);
  // A product stands for how much larger than kPixelsOfWarp the largest footprint may be: the larger the picture, the more.
  return {0.0475 + 6.65e-8 * planes * load.pixels + 5.28e-10 * load.fragments + (3.88e-4 + 1.23e-10 * load.pixels) * load.longestWalk, 0.0480 + 9.32e-7 * load.pixels + 4.09e-8 * load.tiles};
}

}  // namespace warpscope
