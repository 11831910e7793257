// Footprints by vectors, then a parallel sort into tiles.
// See screen_bins.h.
#include "render/warp/splats/screen_bins.h"

#include <tbb/parallel_sort.h>

#include <algorithm>
#include <bit>

#include "render/base/error.h"
#include "render/core/parallel.h"
#include "render/core/simd.h"
#include "render/warp/splats/sphere_footprint.h"

namespace warpscope {
namespace {

constexpr size_t kSpheresInBlock = 8192;
constexpr int kTileShift = std::countr_zero(kSplatTileSide);
static_assert(std::has_single_bit(kSplatTileSide));

/// A hit's distance is the surface's within 16u of (|centre - eye| + radius), see ray_sphere_test.cpp; the distance below adds 4u. This is
/// 32u.
constexpr float kNearestMargin = 32.0f / 16777216.0f;

/// Footprints of spheres[begin .. end).
void footprintsOf(const FootprintView& view, std::span<const Sphere> spheres, SplatFootprint* footprints) {
  constexpr size_t lanes = kBatchLanes;
  alignas(64) float x[lanes] = {}, y[lanes] = {}, z[lanes] = {}, r[lanes] = {};
  alignas(64) int32_t x0[lanes], y0[lanes], x1[lanes], y1[lanes];
  alignas(64) float nearest[lanes];
  for (size_t first = 0; first < spheres.size(); first += lanes) {
    const size_t count = std::min(lanes, spheres.size() - first);
    for (size_t i = 0; i < count; ++i) {
      const Sphere& sphere = spheres[first + i];
      x[i] = sphere.center.x;
      y[i] = sphere.center.y;
      z[i] = sphere.center.z;
      r[i] = sphere.radius;
    }
    const FloatBatch cx = FloatBatch::load_aligned(x) - view.eye.x;
    const FloatBatch cy = FloatBatch::load_aligned(y) - view.eye.y;
    const FloatBatch cz = FloatBatch::load_aligned(z) - view.eye.z;
    const FloatBatch radius = FloatBatch::load_aligned(r);
    const auto bounds = footprint::boundsOf(view, cx, cy, cz, radius);
    bounds.x0.store_aligned(x0);
    bounds.y0.store_aligned(y0);
    bounds.x1.store_aligned(x1);
    bounds.y1.store_aligned(y1);
    const FloatBatch distance = sqrtOf(cx * cx + cy * cy + cz * cz);
    const FloatBatch seen = minOf(radius, 0.5f * distance);  // seenRadius, but for rounding
    const FloatBatch bound = distance - seen - FloatBatch(kNearestMargin) * (distance + radius);
    // Squares may overflow where distances do not.
    selected(distance < FloatBatch(kNoHit), bound, FloatBatch(0.0f)).store_aligned(nearest);
    for (size_t i = 0; i < count; ++i) {
      const bool isEmpty = x0[i] >= x1[i] || y0[i] >= y1[i];
      footprints[first + i] = isEmpty ? SplatFootprint{}
                                      : SplatFootprint{static_cast<uint16_t>(x0[i]), static_cast<uint16_t>(y0[i]),
                                                       static_cast<uint16_t>(x1[i]), static_cast<uint16_t>(y1[i]), nearest[i]};
    }
  }
}

}  // namespace

template <class Visit>
inline void ScreenBins::forEachBin(const SplatFootprint& footprint, const Visit& visit) const {
  if (footprint.x1 == 0) return;
  const uint32_t lastX = footprint.x1 - 1u, lastY = footprint.y1 - 1u;
  uint32_t level = 0;
  int shift = kTileShift;
  while ((lastX >> shift) - (footprint.x0 >> shift) > 1 || (lastY >> shift) - (footprint.y0 >> shift) > 1) {
    ++level;
    ++shift;
  }
  for (uint32_t y = footprint.y0 >> shift; y <= lastY >> shift; ++y)
    for (uint32_t x = footprint.x0 >> shift; x <= lastX >> shift; ++x) visit(levels_[level].firstBin + y * levels_[level].columns + x);
}

ScreenBins::ScreenBins(const Camera& camera, std::span<const Sphere> spheres, const std::stop_token& stop) {
  for (uint32_t side = kSplatTileSide;; side *= 2) {
    const uint32_t columns = (camera.width + side - 1) / side, rows = (camera.height + side - 1) / side;
    levels_.push_back({columns, bins_});
    bins_ += columns * rows;
    if (columns == 1 && rows == 1) break;
  }
  scatter(spheres, camera, stop);
  sortLargeTiles(stop);
}

void ScreenBins::scatter(std::span<const Sphere> spheres, const Camera& camera, const std::stop_token& stop) {
  const size_t count = spheres.size();
  footprints_ = std::make_unique_for_overwrite<SplatFootprint[]>(count);
  // Every block counts all bins: where these are many, blocks are made larger, so that the counters take no more than the entries may.
  const size_t blocks = std::max<size_t>(1, std::min(4 * count / bins_, (count + kSpheresInBlock - 1) / kSpheresInBlock));
  const size_t inBlock = (count + blocks - 1) / blocks;
  std::vector<uint32_t> offsets(blocks * bins_, 0);
  const auto forEachBlock = [&](const auto& body) {
    parallelForRanges(blocks, 1, [&](size_t begin, size_t end) {
      for (size_t block = begin; block < end && !stop.stop_requested(); ++block)
        body(std::min(count, block * inBlock), std::min(count, (block + 1) * inBlock), &offsets[block * bins_]);
    });
    if (stop.stop_requested()) throw OperationCancelled();
  };

  const FootprintView view = footprintViewOf(camera);
  forEachBlock([&](size_t begin, size_t end, uint32_t* counters) {
    footprintsOf(view, spheres.subspan(begin, end - begin), &footprints_[begin]);
    for (size_t i = begin; i < end; ++i) forEachBin(footprints_[i], [&](uint32_t bin) { ++counters[bin]; });
  });
  ends_.resize(bins_);
  uint32_t total = 0;
  for (uint32_t bin = 0; bin < bins_; ++bin) {
    for (size_t block = 0; block < blocks; ++block) {
      uint32_t& counter = offsets[block * bins_ + bin];
      const uint32_t size = counter;
      counter = total;
      total += size;
    }
    ends_[bin] = total;
  }
  entries_ = std::make_unique_for_overwrite<uint32_t[]>(total);
  forEachBlock([&](size_t begin, size_t end, uint32_t* places) {
    for (size_t i = begin; i < end; ++i)
      forEachBin(footprints_[i], [&](uint32_t bin) { entries_[places[bin]++] = static_cast<uint32_t>(i); });
  });
}

void ScreenBins::sortLargeTiles(const std::stop_token& stop) {
  const uint32_t firstBin = levels() > 1 ? levels_[1].firstBin : bins_;
  parallelForRanges(bins_ - firstBin, 16, [&](size_t begin, size_t end) {
    for (size_t i = firstBin + begin; i < firstBin + end && !stop.stop_requested(); ++i)
      tbb::parallel_sort(entries_.get() + ends_[i - 1], entries_.get() + ends_[i], [&](uint32_t a, uint32_t b) {
        return footprints_[a].nearest != footprints_[b].nearest ? footprints_[a].nearest < footprints_[b].nearest : a < b;
      });
  });
  if (stop.stop_requested()) throw OperationCancelled();
}

std::span<const uint32_t> ScreenBins::bin(uint32_t level, uint32_t x, uint32_t y) const {
  const int shift = kTileShift + static_cast<int>(level);
  const uint32_t bin = levels_[level].firstBin + (y >> shift) * levels_[level].columns + (x >> shift);
  return {entries_.get() + (bin == 0 ? 0 : ends_[bin - 1]), entries_.get() + ends_[bin]};
}

}  // namespace warpscope
