// Which spheres may be seen in which part of the screen: their footprints, sorted into tiles. Host only.
// Count, scan, scatter (cf. Blelloch 1990, section 1.3) into a pyramid of tiles, so that a sphere has few entries however large it is.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <stop_token>
#include <vector>

#include "render/core/camera.h"
#include "render/core/sample.h"

namespace warpscope {

/// Edge of the smallest tiles in pixels, a power of two. Level l of the pyramid has tiles of kSplatTileSide * 2^l.
inline constexpr uint32_t kSplatTileSide = 32;

/// Where on the screen a sphere may be seen, and how far away at least. Half-open; empty (all 0) where it cannot be seen.
struct SplatFootprint {
  uint16_t x0, y0, x1, y1;
  float nearest;  ///< no distance that intersectSphere finds is smaller
};

/// A cloud as one camera sees it. Memory: 12 bytes a sphere for footprints and at most 4 entries of 4 bytes, whatever the spheres cover.
class ScreenBins {
 public:
  /// `camera` isUsable; the spheres are as validateSpheres asks for. Throws OperationCancelled if `stop` is set. The result does not
  /// depend on the number of threads.
  ScreenBins(const Camera& camera, std::span<const Sphere> spheres, const std::stop_token& stop);

  uint32_t levels() const { return static_cast<uint32_t>(levels_.size()); }

  /// Places in the cloud of the spheres that may be seen in the tile of `level` that holds pixel (x, y), but for those of other levels. On
  /// levels above 0 nearer ones come first (see SplatFootprint::nearest), on level 0 they are in the cloud's order.
  std::span<const uint32_t> bin(uint32_t level, uint32_t x, uint32_t y) const;

  const SplatFootprint& footprint(uint32_t sphere) const { return footprints_[sphere]; }

 private:
  struct Level {
    uint32_t columns;
    uint32_t firstBin;
  };

  void scatter(std::span<const Sphere> spheres, const Camera& camera, const std::stop_token& stop);
  void sortLargeTiles(const std::stop_token& stop);
  /// Visits the tiles that the footprint reaches into, on the first level where these are at most two by two. The top has one tile.
  template <class Visit>
  void forEachBin(const SplatFootprint& footprint, const Visit& visit) const;

  std::vector<Level> levels_;
  uint32_t bins_ = 0;
  std::unique_ptr<SplatFootprint[]> footprints_;
  std::unique_ptr<uint32_t[]> entries_;
  std::vector<uint32_t> ends_;  // of each bin in entries_
};

}  // namespace warpscope
