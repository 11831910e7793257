// Every sphere's footprint is walked, and of what the rays of its pixels hit the nearest is kept. For .cu files.
// A thread for each sphere; where those of a warp have unequally much to do they share its pixels, and footprints that would hold the picture up are walked by many blocks. What counts as a
// hit and how many are kept for a pixel is the caller's.
#pragma once

#include <numeric>
#include <type_traits>

#include "render/core/ray_sphere.h"
#include "render/cuda/memory.h"
#include "render/cuda/pixel_tiles.cuh"
#include "render/cuda/warp_reduce.cuh"
#include "render/warp/device/device_frame.h"
#include "render/warp/device/earliest_hit.cuh"
#include "render/warp/splats/footprint_limits.h"
#include "render/warp/splats/sphere_footprint.h"

namespace warpscope {

constexpr unsigned kWalkThreads = 128;

/// Blocks that share the large footprints: enough for 9 at once, as many as there are registers for, on 200 multiprocessors. More take longer to find that there are none.
constexpr unsigned kLargeBlocks = 2048;

/// What is kept of a hit: bits of its distance above, the sample's place in the frame below. Nearer hits are smaller, of equally near ones those that come first in the frame.
using KeptHit = unsigned long long;
constexpr KeptHit kNoKeptHit = 0xffffffffffffffffull;

__device__ inline KeptHit keptHit(float distance, uint32_t id) { return KeptHit{__float_as_uint(distance)} << 32 | id; }

/// Planes of kept hits, one behind the other: of each pixel the first, the second and so on.
struct HitPlanes {
  KeptHit* hits = nullptr;
  uint32_t perRow = 0;  ///< even, so that pixels can be read in pairs
  uint32_t height = 0;

  __host__ __device__ size_t size() const { return size_t{perRow} * height; }
  __device__ size_t at(uint32_t x, uint32_t y) const { return size_t{y} * perRow + x; }
};

/// For a picture of the camera's, without memory.
inline HitPlanes planesFor(const Camera& camera) { return {nullptr, (camera.width + 1) / 2 * 2, camera.height}; }

/// Which spheres may be passed over.
struct WantedTiles {
  static constexpr int kSide = 4;
  const uint8_t* isWanted = nullptr;  ///< per tile of kSide x kSide pixels, row by row: 0 where none of its pixels wants a hit; null: all do
  uint32_t perRow = 0;
};

/// Hits: how many of them are kept for a pixel (kKept); whether spheres beside each other mostly have about as many pixels (kAreAlike); footprintOf(view, id, sphere), all pixels that may
/// have one; distanceOf(id, direction, toCenter, t), which distance counts where a ray meets the sphere at t: never less than t, and kNoHit for what is no hit after all.
template <class Hits>
struct SplatJob {
  Hits of;
  DeviceFrameView frame;
  Camera camera;
  FootprintView footprint;
  float margin;  ///< of distances, for rounding
  float edge;    ///< pixelEdge
  HitPlanes planes;
  WantedTiles wanted;
  uint32_t* large;
  uint32_t* largeCount;
  uint32_t stride;  ///< as strideFor() says
};

/// A sphere from the eye.
struct Splat {
  float4 widened;  ///< centre and widenedSquare
  float radius;
  float outside;
  float nearest;  ///< at most the distance of any hit
  uint32_t id;
};

template <class Hits>
__device__ Splat splatOf(const SplatJob<Hits>& job, const Sphere& sphere, uint32_t id) {
  const glm::vec3 toCenter = sphere.center - job.camera.eye;
  const float distance = sqrtf(glm::dot(toCenter, toCenter));
  const SeenSphere seen = seenSphere(toCenter, sphere.radius);
  return {{toCenter.x, toCenter.y, toCenter.z, widenedSquare(distance, seen.radius)},
          seen.radius,
          seen.outside,
          distance - seen.radius - job.margin,
          id};
}

/// A pixel's hits, of which `last` is the farthest that is kept. kLooksFirst: a quick test rules out most of a large footprint's pixels, where others are nearer; in small ones it costs
/// more than it saves.
template <bool kLooksFirst, class Hits>
__device__ void splatPixel(const SplatJob<Hits>& job, const Splat& splat, uint32_t x, uint32_t y, KeptHit last) {
  const float farthest = __uint_as_float(static_cast<uint32_t>(last >> 32));  // no number while there is room: no comparison holds
  if (splat.nearest > farthest) return;
  if constexpr (kLooksFirst) {
    const float earliest = earliestHit(quickDirection(job.camera, job.edge, x, y), splat.widened);
    if (!(earliest < kNoHit) || earliest > farthest) return;
  }
  const glm::vec3 direction = rayOfPixel(job.camera, {x, y}).direction, toCenter(splat.widened.x, splat.widened.y, splat.widened.z);
  const float t = intersectSphereFromOrigin(direction, toCenter, splat.radius, splat.outside);
  if (!(t < kNoHit)) return;
  const float distance = job.of.distanceOf(splat.id, direction, toCenter, t);
  if (!(distance < kNoHit)) return;
  KeptHit hit = keptHit(distance, splat.id);
  if (!(hit < last)) return;
  // Each place takes the smaller and hands the larger on: whatever comes when, the least are there in the end, in order (Liu, Huang, Liu, Wu 2009, "Single pass depth peeling via CUDA
  // rasterizer").
  KeptHit* place = job.planes.hits + job.planes.at(x, y);
  if constexpr (Hits::kKept == 1) {
    atomicMin(place, hit);
  } else {
    for (int k = 0; k < Hits::kKept && hit != kNoKeptHit; ++k, place += job.planes.size()) hit = max(hit, atomicMin(place, hit));
  }
}

template <class Hits>
__device__ const KeptHit* lastPlane(const SplatJob<Hits>& job) {
  return job.planes.hits + (Hits::kKept - 1) * job.planes.size();
}

/// One pixel, by one of several lanes side by side.
template <bool kLooksFirst, class Hits>
__device__ void splatAlone(const SplatJob<Hits>& job, const Splat& splat, uint32_t x, uint32_t y) {
  splatPixel<kLooksFirst>(job, splat, x, y, __ldcg(lastPlane(job) + job.planes.at(x, y)));
}

/// A whole footprint, by one lane. What it reads may get nearer meanwhile, never farther: a stale value costs a test, nothing else.
template <bool kLooksFirst, class Hits>
__device__ void splatAll(const SplatJob<Hits>& job, const Splat& splat, const PixelRect& rect) {
  // One loop over all pixels: with one inside another, lanes with narrow footprints would wait at the end of every row. Two pixels are read at once, and the next two meanwhile.
  const int first = rect.x0 / 2 * 2, last = (rect.x1 - 1) / 2 * 2;
  const auto read = [&](int x, int y) {
    return __ldcg(reinterpret_cast<const ulonglong2*>(lastPlane(job) + job.planes.at(static_cast<uint32_t>(x), static_cast<uint32_t>(y))));
  };
  int nextX = first, nextY = rect.y0;
  ulonglong2 next = read(nextX, nextY);
  while (nextY != rect.y1) {
    const ulonglong2 there = next;
    const int x = nextX, y = nextY;
    if (x == last) {
      nextX = first;
      ++nextY;
    } else {
      nextX += 2;
    }
    if (nextY != rect.y1) next = read(nextX, nextY);
    if (x >= rect.x0) splatPixel<kLooksFirst>(job, splat, static_cast<uint32_t>(x), static_cast<uint32_t>(y), there.x);
    if (x + 1 < rect.x1) splatPixel<kLooksFirst>(job, splat, static_cast<uint32_t>(x + 1), static_cast<uint32_t>(y), there.y);
  }
}

/// The part of the footprint around tiles that may want a hit.
__device__ inline PixelRect wantedPart(const WantedTiles& wanted, const PixelRect& rect) {
  if (wanted.isWanted == nullptr || rect.isEmpty()) return rect;
  constexpr int kMostTiles = 64;  // to look at
  constexpr int kSide = WantedTiles::kSide;
  const int x0 = rect.x0 / kSide, x1 = (rect.x1 - 1) / kSide, y0 = rect.y0 / kSide, y1 = (rect.y1 - 1) / kSide;
  if ((x1 - x0 + 1) * (y1 - y0 + 1) > kMostTiles) return rect;
  PixelRect part{rect.x1, rect.y1, rect.x0, rect.y0};
  for (int y = y0; y <= y1; ++y)
    for (int x = x0; x <= x1; ++x) {
      if (wanted.isWanted[static_cast<uint32_t>(y) * wanted.perRow + static_cast<uint32_t>(x)] == 0) continue;
      part = {min(part.x0, x * kSide), min(part.y0, y * kSide), max(part.x1, (x + 1) * kSide), max(part.y1, (y + 1) * kSide)};
    }
  return {max(part.x0, rect.x0), max(part.y0, rect.y0), min(part.x1, rect.x1), min(part.y1, rect.y1)};
}

__device__ inline uint32_t areaOf(const PixelRect& rect) {
  return rect.isEmpty() ? 0u : static_cast<uint32_t>(rect.x1 - rect.x0) * static_cast<uint32_t>(rect.y1 - rect.y0);
}

/// Spheres of a warp whose footprints its lanes walk together: those that have any, one behind the other.
struct SharedFootprints {
  float4 widened[32];
  float radius[32], outside[32], nearest[32], perWidth[32];
  uint32_t id[32];
  uint32_t first[32];  ///< of its pixels among those of all
  int x0[32], y0[32], width[32];
};

/// Every lane a pixel, and the next 32, whosesoever they are: no lane waits for another's larger footprint. `first`: how many pixels the lanes before have; `all`: those of the warp.
template <bool kLooksFirst, class Hits>
__device__ void splatTogether(const SplatJob<Hits>& job, SharedFootprints& shared, const Sphere& sphere, uint32_t id, const PixelRect& rect, uint32_t first, uint32_t all) {
  const uint32_t lane = threadIdx.x % 32, upToLane = 0xffffffffu >> (31 - lane);
  const bool hasAny = !rect.isEmpty();
  const uint32_t walked = __ballot_sync(kAllLanes, hasAny);
  if (hasAny) {
    const int at = __popc(walked & upToLane) - 1;
    const Splat splat = splatOf(job, sphere, id);
    shared.widened[at] = splat.widened;
    shared.radius[at] = splat.radius;
    shared.outside[at] = splat.outside;
    shared.nearest[at] = splat.nearest;
    shared.id[at] = id;
    shared.first[at] = first;
    shared.x0[at] = rect.x0;
    shared.y0[at] = rect.y0;
    shared.width[at] = rect.x1 - rect.x0;
    shared.perWidth[at] = 1.0f / static_cast<float>(rect.x1 - rect.x0);
  }
  __syncwarp();
  int begun = -1;  // the last whose pixels have begun
  for (uint32_t turn = 0; turn < all; turn += 32) {
    const uint32_t begins = warpOr(hasAny && first - turn < 32 ? 1u << (first - turn) : 0u);
    const int at = begun + __popc(begins & upToLane);
    begun += __popc(begins);
    if (turn + lane >= all) continue;
    const uint32_t pixel = turn + lane - shared.first[at];
    const int row = rowOfPixel(pixel, shared.perWidth[at]);
    const auto x = static_cast<uint32_t>(shared.x0[at] + static_cast<int>(pixel) - row * shared.width[at]), y = static_cast<uint32_t>(shared.y0[at] + row);
    splatAlone<kLooksFirst>(job, {shared.widened[at], shared.radius[at], shared.outside[at], shared.nearest[at], shared.id[at]}, x, y);
  }
}

/// Each lane walks its own footprint where the largest has no more than so many times the pixels that all lanes have in the mean.
constexpr float kMostUneven = 1.5f;
/// Pixels of a lane in the mean, from which on a quick test of each saves more than it takes. Of pieces, which are small, and in gaps it was not tried.
constexpr uint32_t kLooksFrom = 64;

/// Threads of a multiprocessor that there are to be registers for: of compute capability 7.5 it has no more.
#if defined(__CUDA_ARCH__) && __CUDA_ARCH__ < 800
template <class Hits>
constexpr unsigned kThreadsThatWalk = 1024;
#else
template <class Hits>
constexpr unsigned kThreadsThatWalk = Hits::kAreAlike ? 1024 : 1536;
#endif

template <class Hits>
__global__ void __launch_bounds__(kWalkThreads, kThreadsThatWalk<Hits> / kWalkThreads) splatSamples(const __grid_constant__ SplatJob<Hits> job) {
  __shared__ SharedFootprints shared[kWalkThreads / 32];
  // Seen from aside, samples in the order of the server's pixels come ever nearer at a pixel; out of order, few find themselves to be nearest.
  const auto turn = static_cast<uint32_t>(uint64_t{blockIdx.x} * job.stride % gridDim.x);
  const uint32_t i = turn * kWalkThreads + threadIdx.x;
  Sphere sphere{};
  PixelRect rect{0, 0, 0, 0};
  if (i < job.frame.count) {
    sphere = unpackSample(job.frame.samples[i], job.frame.grid);
    rect = wantedPart(job.wanted, job.of.footprintOf(job.footprint, i, sphere));
  }
  if (areaOf(rect) > kPixelsOfWarp) {
    job.large[atomicAdd(job.largeCount, 1u)] = i;
    rect = {0, 0, 0, 0};
  }
  const uint32_t area = areaOf(rect);
  const WarpSums pixels = warpSums(area);
  const auto together = [&](auto looksFirst) {
    splatTogether<looksFirst.value>(job, shared[threadIdx.x / 32], sphere, i, rect, pixels.before, pixels.all);
  };
  if constexpr (Hits::kAreAlike) {
    const bool areEven = static_cast<float>(32 * warpMax(area)) <= kMostUneven * static_cast<float>(pixels.all);
    const auto walk = [&](auto looksFirst) {
      if (!areEven)
        together(looksFirst);
      else if (area > 0)
        splatAll<looksFirst.value>(job, splatOf(job, sphere, i), rect);
    };
    if (pixels.all > 32 * kLooksFrom)
      walk(std::true_type{});
    else
      walk(std::false_type{});
  } else {
    together(std::false_type{});
  }
}

/// A stride that leads once through all of `count` blocks, far from each to the next.
inline uint32_t strideFor(uint32_t count) {
  auto stride = static_cast<uint32_t>(0.618 * count) | 1u;
  while (std::gcd(stride, count) != 1) ++stride;
  return stride;
}

/// Blocks share the large footprints: while there are fewer of these than of those, each is cut into bands of rows.
template <class Hits>
__global__ void __launch_bounds__(kWalkThreads) splatLarge(const __grid_constant__ SplatJob<Hits> job) {
  const uint32_t count = *job.largeCount;
  if (count == 0) return;
  const uint32_t bands = max(1u, gridDim.x / count);
  for (uint64_t unit = blockIdx.x; unit < uint64_t{count} * bands; unit += gridDim.x) {
    const uint32_t id = job.large[unit / bands];
    const auto band = static_cast<uint32_t>(unit % bands);
    const Sphere sphere = unpackSample(job.frame.samples[id], job.frame.grid);
    const PixelRect rect = job.of.footprintOf(job.footprint, id, sphere);
    const Splat splat = splatOf(job, sphere, id);
    const auto rows = static_cast<uint32_t>(rect.y1 - rect.y0);
    const uint32_t first = static_cast<uint32_t>(rect.y0) + static_cast<uint32_t>(uint64_t{rows} * band / bands);
    const uint32_t end = static_cast<uint32_t>(rect.y0) + static_cast<uint32_t>(uint64_t{rows} * (band + 1) / bands);
    const auto width = static_cast<uint32_t>(rect.x1 - rect.x0);
    for (uint32_t k = threadIdx.x; k < (end - first) * width; k += kWalkThreads)
      splatAlone<true>(job, splat, static_cast<uint32_t>(rect.x0) + k % width, first + k / width);
  }
}

/// Hits of spheres as they are, of which the nearest is kept.
struct NearestOfSpheres {
  static constexpr int kKept = 1;
  static constexpr bool kAreAlike = true;
  __device__ PixelRect footprintOf(const FootprintView& view, uint32_t, const Sphere& sphere) const { return sphereFootprint(view, sphere); }
  __device__ float distanceOf(uint32_t, const glm::vec3&, const glm::vec3&, float t) const { return t; }
};

/// The same where few pixels want one: what is left of footprints that are alike is not.
struct NearestInGaps : NearestOfSpheres {
  static constexpr bool kAreAlike = false;
};

/// What the walk needs beside hits.
class FootprintWalk {
 public:
  /// Into `planes`, whose kept hits it goes on from, in stream order, without waiting and, once the buffers have their size, without allocating.
  template <class Hits>
  void walk(const Hits& hits, const DeviceFrameView& frame, const Camera& camera, const HitPlanes& planes, const WantedTiles& wanted, cudaStream_t stream) {
    if (frame.count == 0) return;
    large_.reserve(frame.count);
    WARPSCOPE_CUDA_CHECK(cudaMemsetAsync(largeCount_.data(), 0, sizeof(uint32_t), stream));
    const glm::vec3 eye = glm::abs(camera.eye);
    const float margin = kFootprintMargin * (eye.x + eye.y + eye.z + frame.reach());
    const unsigned blocks = cuda::blocksFor(frame.count, kWalkThreads);
    const SplatJob<Hits> job{hits, frame, camera, footprintViewOf(camera), margin, pixelEdge(camera), planes, wanted, large_.data(), largeCount_.data(), strideFor(blocks)};
    splatSamples<<<blocks, kWalkThreads, 0, stream>>>(job);
    WARPSCOPE_CUDA_CHECK_LAUNCH();
    splatLarge<<<kLargeBlocks, kWalkThreads, 0, stream>>>(job);
    WARPSCOPE_CUDA_CHECK_LAUNCH();
  }

 private:
  cuda::DeviceBuffer<uint32_t> large_;  // samples with large footprints
  cuda::DeviceBuffer<uint32_t> largeCount_{1};
};

}  // namespace warpscope
