// A task owns a tile of the screen, its distances and ids; no two tasks write the same pixel.
// See splat_tracer.h.
#include "render/warp/splats/splat_tracer.h"

#include <algorithm>
#include <array>
#include <bit>
#include <string>

#include "render/base/error.h"
#include "render/core/parallel.h"
#include "render/warp/lbvh/ray_packet.h"
#include "render/warp/splats/screen_bins.h"

namespace warpscope {
namespace {

/// A vector holds a block of pixels: of all shapes the one that small footprints fill best.
constexpr uint32_t kBlockWidth = std::min(kPackLanes, 4u);
constexpr uint32_t kBlockHeight = kPackLanes / kBlockWidth;
constexpr uint32_t kBlockColumns = kSplatTileSide / kBlockWidth;
constexpr uint32_t kBlockRows = kSplatTileSide / kBlockHeight;
constexpr uint32_t kBlocks = kBlockColumns * kBlockRows;

/// Sets of blocks are words of bits, row after row.
constexpr uint32_t kBlocksInWord = 64;
constexpr uint32_t kRowsInWord = kBlocksInWord / kBlockColumns;
constexpr uint64_t kFirstColumn = ~uint64_t{0} / ((uint64_t{1} << kBlockColumns) - 1);
static_assert(kBlockColumns == 8 && kBlocks % kBlocksInWord == 0);

constexpr uint32_t kPixels = kSplatTileSide * kSplatTileSide;
static_assert(kSplatTileSide % kBlockWidth == 0 && kSplatTileSide % kBlockHeight == 0 && kBlocks % kPackLanes == 0);

class SplatTile {
 public:
  SplatTile(const Camera& camera, uint32_t x0, uint32_t y0, uint32_t x1, uint32_t y1)
      : camera_(camera), x0_(x0), y0_(y0), x1_(x1), y1_(y1) {
    alignas(64) std::array<float, kPackLanes> laneX, laneY;
    for (uint32_t lane = 0; lane < kPackLanes; ++lane) {
      laneX[lane] = static_cast<float>(lane % kBlockWidth);
      laneY[lane] = static_cast<float>(lane / kBlockWidth);
    }
    for (uint32_t block = 0; block < kBlocks; ++block) {
      const uint32_t first = block * kPackLanes;
      const FloatPack x = static_cast<float>(x0 + block % kBlockColumns * kBlockWidth) + FloatPack::load_aligned(laneX.data());
      const FloatPack y = static_cast<float>(y0 + block / kBlockColumns * kBlockHeight) + FloatPack::load_aligned(laneY.data());
      const Vec3Pack direction = pixelDirections(camera, x + 0.5f, y + 0.5f);
      direction.x.store_aligned(&directionX_[first]);
      direction.y.store_aligned(&directionY_[first]);
      direction.z.store_aligned(&directionZ_[first]);
      // Pixels outside the image are hit by nothing and never the farthest.
      const FloatMask inside = (x < FloatPack(static_cast<float>(x1))) & (y < FloatPack(static_cast<float>(y1)));
      const FloatPack t = xsimd::select(inside, FloatPack(kNoHit), FloatPack(-kNoHit));
      t.store_aligned(&t_[first]);
      IntPack(-1).store_aligned(&id_[first]);
      farthest_[block] = xsimd::any(inside) ? kNoHit : -kNoHit;
    }
  }

  /// Intersects the sphere with the pixels of its footprint that have met nothing nearer yet.
  void splat(const Sphere& sphere, uint32_t id, const SplatFootprint& footprint) {
    const uint32_t column0 = (std::max<uint32_t>(footprint.x0, x0_) - x0_) / kBlockWidth;
    const uint32_t column1 = (std::min<uint32_t>(footprint.x1, x1_) - x0_ - 1) / kBlockWidth;
    const uint32_t row0 = (std::max<uint32_t>(footprint.y0, y0_) - y0_) / kBlockHeight;
    const uint32_t row1 = (std::min<uint32_t>(footprint.y1, y1_) - y0_ - 1) / kBlockHeight;
    const glm::vec3 toCenter = sphere.center - camera_.eye;
    const IntPack idPack(static_cast<int32_t>(id));
    const uint64_t columns = (2u << column1) - (1u << column0);
    for (uint32_t word = row0 / kRowsInWord; word <= row1 / kRowsInWord; ++word) {
      const uint32_t firstRow = word * kRowsInWord;
      const uint32_t low = row0 > firstRow ? row0 - firstRow : 0;
      const uint32_t high = std::min(row1 - firstRow, kRowsInWord - 1);
      const uint64_t rows = kFirstColumn << (kBlockColumns * low) & kFirstColumn >> (kBlockColumns * (kRowsInWord - 1 - high));
      const uint32_t firstBlock = word * kBlocksInWord;
      for (uint64_t blocks = columns * rows & blocksBeyond(firstBlock, footprint.nearest); blocks != 0; blocks &= blocks - 1)
        splatBlock(firstBlock + static_cast<uint32_t>(std::countr_zero(blocks)), toCenter, sphere.radius, idPack);
    }
  }

  /// Of all pixels' distances the largest.
  float farthest() const {
    FloatPack farthest = FloatPack::load_aligned(&farthest_[0]);
    for (uint32_t i = kPackLanes; i < kBlocks; i += kPackLanes) farthest = xsimd::max(farthest, FloatPack::load_aligned(&farthest_[i]));
    return largestLane(farthest);
  }

  void store(Image<uint32_t>& ids, Image<float>* depth) const {
    for (uint32_t y = y0_; y < y1_; ++y)
      for (uint32_t x = x0_; x < x1_; x += kBlockWidth) {
        const uint32_t block = (y - y0_) / kBlockHeight * kBlockColumns + (x - x0_) / kBlockWidth;
        const uint32_t first = block * kPackLanes + (y - y0_) % kBlockHeight * kBlockWidth;
        const uint32_t count = std::min(kBlockWidth, x1_ - x);
        std::transform(&id_[first], &id_[first] + count, ids.row(y) + x, [](int32_t id) { return static_cast<uint32_t>(id); });
        if (depth) std::copy_n(&t_[first], count, depth->row(y) + x);
      }
  }

 private:
  /// Which of the kBlocksInWord blocks from `first` on hold a pixel that has met nothing nearer than `distance`, as bits.
  uint64_t blocksBeyond(uint32_t first, float distance) const {
    uint64_t bits = 0;
    for (uint32_t i = 0; i < kBlocksInWord; i += kPackLanes)
      bits |= uint64_t{laneBits(FloatPack(distance) <= FloatPack::load_aligned(&farthest_[first + i]))} << i;
    return bits;
  }

  void splatBlock(uint32_t block, const glm::vec3& toCenter, float radius, const IntPack& id) {
    const uint32_t first = block * kPackLanes;
    const Vec3Pack direction{FloatPack::load_aligned(&directionX_[first]), FloatPack::load_aligned(&directionY_[first]),
                             FloatPack::load_aligned(&directionZ_[first])};
    const HitPack hit{intersectSpherePack(direction, toCenter, radius), id};
    const HitPack best{FloatPack::load_aligned(&t_[first]), IntPack::load_aligned(&id_[first])};
    const FloatMask nearer = isNearer(hit, best);
    if (!xsimd::any(nearer)) return;
    const HitPack kept = select(nearer, hit, best);
    kept.t.store_aligned(&t_[first]);
    kept.id.store_aligned(&id_[first]);
    farthest_[block] = largestLane(kept.t);
  }

  const Camera& camera_;
  uint32_t x0_, y0_, x1_, y1_;
  alignas(64) std::array<float, kPixels> directionX_, directionY_, directionZ_, t_;  // block after block
  alignas(64) std::array<int32_t, kPixels> id_;
  alignas(64) std::array<float, kBlocks> farthest_;  // of each block's distances
};

/// The places of `bin`, roughly from near to far: a counting sort by distance in equal steps.
void orderByDistance(std::span<const uint32_t> bin, const ScreenBins& bins, std::vector<uint32_t>& ordered) {
  constexpr uint32_t kSteps = 512;
  float low = kNoHit, high = -kNoHit;
  for (const uint32_t id : bin) {
    low = std::min(low, bins.footprint(id).nearest);
    high = std::max(high, bins.footprint(id).nearest);
  }
  const float stepsPerUnit = high > low ? (kSteps - 1) / (high - low) : 0.0f;
  const auto stepOf = [&](uint32_t id) {
    return std::min(static_cast<uint32_t>((bins.footprint(id).nearest - low) * stepsPerUnit), kSteps - 1);
  };
  std::array<uint32_t, kSteps> places{};
  for (const uint32_t id : bin) ++places[stepOf(id)];
  uint32_t total = 0;
  for (uint32_t& place : places) {
    const uint32_t size = place;
    place = total;
    total += size;
  }
  ordered.resize(bin.size());
  for (const uint32_t id : bin) ordered[places[stepOf(id)]++] = id;
}

}  // namespace

void SplatTracer::build(std::span<const Sphere> spheres) {
  spheres_.clear();
  if (spheres.size() > kMaxSplats)
    throw InputError("at most " + std::to_string(kMaxSplats) + " spheres can be splatted, not " + std::to_string(spheres.size()));
  validateSpheres(spheres);
  spheres_.assign(spheres.begin(), spheres.end());
}

void SplatTracer::trace(const Camera& camera, Image<uint32_t>& ids, Image<float>* depth, const std::stop_token& stop) const {
  ids.reshape(camera.width, camera.height);
  if (depth) depth->reshape(camera.width, camera.height);
  const ScreenBins bins(camera, spheres_, stop);
  parallelForTiles(camera.width, camera.height, kSplatTileSide, stop, [&](uint32_t x0, uint32_t y0, uint32_t x1, uint32_t y1) {
    SplatTile tile(camera, x0, y0, x1, y1);
    // Large ones first: they are near, as a rule, and hide much.
    for (uint32_t level = bins.levels() - 1; level > 0; --level) {
      for (const uint32_t id : bins.bin(level, x0, y0)) {
        const SplatFootprint& footprint = bins.footprint(id);
        if (footprint.nearest > tile.farthest()) break;
        if (footprint.x0 < x1 && footprint.x1 > x0 && footprint.y0 < y1 && footprint.y1 > y0) tile.splat(spheres_[id], id, footprint);
      }
    }
    std::vector<uint32_t> ordered;
    orderByDistance(bins.bin(0, x0, y0), bins, ordered);
    for (const uint32_t id : ordered) tile.splat(spheres_[id], id, bins.footprint(id));
    tile.store(ids, depth);
  });
}

}  // namespace warpscope
