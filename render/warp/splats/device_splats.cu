// Small, middling and large footprints.
// See device_splats.h.
#include "render/warp/splats/device_splats.h"

#include <numeric>

#include "render/core/ray_sphere.h"
#include "render/cuda/pixel_tiles.cuh"
#include "render/cuda/warp_reduce.cuh"
#include "render/warp/device/earliest_hit.cuh"
#include "render/warp/splats/sphere_footprint.h"

namespace warpscope {
namespace {

constexpr unsigned kThreads = 128;

/// Pixels that one thread walks alone, whatever its neighbours do.
constexpr uint32_t kPixelsAlone = 64;
/// Pixels that one thread walks alone if its neighbours have as much to do; beyond, lanes side by side read memory better.
constexpr uint32_t kPixelsBeside = 256;
/// Pixels that one warp walks; more are for many blocks, because a warp has no more than its share of one multiprocessor.
constexpr uint32_t kPixelsOfWarp = 8192;
/// Blocks that share the large footprints: enough to fill any device several times over.
constexpr unsigned kLargeBlocks = 4096;

constexpr unsigned long long kNothing = 0xffffffffffffffffull;

struct SplatJob {
  DeviceFrameView frame;
  Camera camera;
  FootprintView footprint;
  float margin;  ///< of distances, for rounding
  float edge;    ///< pixelEdge
  unsigned long long* nearest;
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

__device__ Splat splatOf(const SplatJob& job, const Sphere& sphere, uint32_t id) {
  const glm::vec3 toCenter = sphere.center - job.camera.eye;
  const float distance = sqrtf(glm::dot(toCenter, toCenter));
  const SeenSphere seen = seenSphere(toCenter, sphere.radius);
  return {{toCenter.x, toCenter.y, toCenter.z, widenedSquare(distance, seen.radius)},
          seen.radius,
          seen.outside,
          distance - seen.radius - job.margin,
          id};
}

/// kLooksFirst: a quick test rules out most of a large footprint's pixels, where others are nearer; in small ones it costs more than it saves.
template <bool kLooksFirst>
__device__ void splatPixel(const SplatJob& job, const Splat& splat, uint32_t x, uint32_t y) {
  unsigned long long* place = job.nearest + size_t{y} * job.camera.width + x;
  // What is there may get nearer meanwhile, never farther: a stale value costs a test, nothing else.
  const unsigned long long there = __ldcg(place);
  const float nearest = __uint_as_float(static_cast<uint32_t>(there >> 32));  // no number while nothing is there: no comparison holds
  if (splat.nearest > nearest) return;
  if constexpr (kLooksFirst) {
    const float earliest = earliestHit(quickDirection(job.camera, job.edge, x, y), splat.widened);
    if (!(earliest < kNoHit) || earliest > nearest) return;
  }
  const glm::vec3 direction = rayOfPixel(job.camera, {x, y}).direction;
  const float t = intersectSphereFromOrigin(direction, {splat.widened.x, splat.widened.y, splat.widened.z}, splat.radius, splat.outside);
  if (!(t < kNoHit)) return;
  const unsigned long long candidate = static_cast<unsigned long long>(__float_as_uint(t)) << 32 | splat.id;
  if (candidate < there) atomicMin(place, candidate);
}

__device__ uint32_t areaOf(const PixelRect& rect) {
  return rect.isEmpty() ? 0u : static_cast<uint32_t>(rect.x1 - rect.x0) * static_cast<uint32_t>(rect.y1 - rect.y0);
}

__device__ int shuffled(int value, int lane) { return __shfl_sync(kAllLanes, value, lane); }

/// Up to how many pixels the warp's lanes walk for themselves: their turns are then those of the largest footprint, and otherwise the sum of
/// all that are left to the warp as a whole.
__device__ uint32_t pixelsAlone(uint32_t area, const PixelRect& rect) {
  const bool isOne = area > kPixelsAlone && area <= kPixelsBeside;
  const auto tiles = static_cast<uint32_t>(((rect.x1 - rect.x0 + 7) / 8) * ((rect.y1 - rect.y0 + 3) / 4));
  uint32_t largest = isOne ? area : 0u, turns = isOne ? tiles + 1 : 0u;
  for (int step = 16; step > 0; step /= 2) {
    largest = max(largest, __shfl_xor_sync(kAllLanes, largest, step));
    turns += __shfl_xor_sync(kAllLanes, turns, step);
  }
  return largest <= turns ? kPixelsBeside : kPixelsAlone;
}

__global__ void __launch_bounds__(kThreads) splatSamples(const __grid_constant__ SplatJob job) {
  // Seen from aside, samples in the order of the server's pixels come ever nearer at a pixel; out of order, few find themselves to be nearest.
  const auto turn = static_cast<uint32_t>(uint64_t{blockIdx.x} * job.stride % gridDim.x);
  const uint32_t i = turn * kThreads + threadIdx.x;
  const int lane = static_cast<int>(threadIdx.x % 32);
  Sphere sphere{};
  PixelRect rect{0, 0, 0, 0};
  if (i < job.frame.count) {
    sphere = unpackSample(job.frame.samples[i], job.frame.grid);
    rect = sphereFootprint(job.footprint, sphere);
  }
  const uint32_t area = areaOf(rect);
  const uint32_t alone = pixelsAlone(area, rect);
  if (area > 0 && area <= alone) {
    const Splat splat = splatOf(job, sphere, i);
    // One loop over all pixels: with one inside another, lanes with narrow footprints would wait at the end of every row.
    int x = rect.x0, y = rect.y0;
    for (uint32_t k = 0; k < area; ++k) {
      splatPixel<false>(job, splat, static_cast<uint32_t>(x), static_cast<uint32_t>(y));
      if (++x == rect.x1) {
        x = rect.x0;
        ++y;
      }
    }
  }
  if (area > kPixelsOfWarp) job.large[atomicAdd(job.largeCount, 1u)] = i;
  __syncwarp();
  for (uint32_t rest = __ballot_sync(kAllLanes, area > alone && area <= kPixelsOfWarp); rest != 0; rest &= rest - 1) {
    const int owner = __ffs(static_cast<int>(rest)) - 1;
    const Sphere shared{{__shfl_sync(kAllLanes, sphere.center.x, owner), __shfl_sync(kAllLanes, sphere.center.y, owner),
                         __shfl_sync(kAllLanes, sphere.center.z, owner)},
                        __shfl_sync(kAllLanes, sphere.radius, owner)};
    const int x0 = shuffled(rect.x0, owner), y0 = shuffled(rect.y0, owner);
    const int width = shuffled(rect.x1, owner) - x0, height = shuffled(rect.y1, owner) - y0;
    const Splat splat = splatOf(job, shared, i - static_cast<uint32_t>(lane) + static_cast<uint32_t>(owner));
    // In tiles of 8 x 4, which need no division to find a lane's pixel.
    for (int y = y0 + lane / 8; y - lane / 8 < y0 + height; y += 4)
      for (int x = x0 + lane % 8; x - lane % 8 < x0 + width; x += 8)
        if (x < x0 + width && y < y0 + height) splatPixel<true>(job, splat, static_cast<uint32_t>(x), static_cast<uint32_t>(y));
  }
}

/// A stride that leads once through all of `count` blocks, far from each to the next.
uint32_t strideFor(uint32_t count) {
  auto stride = static_cast<uint32_t>(0.618 * count) | 1u;
  while (std::gcd(stride, count) != 1) ++stride;
  return stride;
}

/// Blocks share the large footprints: while there are fewer of these than of those, each is cut into bands of rows.
__global__ void __launch_bounds__(kThreads) splatLarge(const __grid_constant__ SplatJob job) {
  const uint32_t count = *job.largeCount;
  if (count == 0) return;
  const uint32_t bands = max(1u, gridDim.x / count);
  for (uint64_t unit = blockIdx.x; unit < uint64_t{count} * bands; unit += gridDim.x) {
    const uint32_t id = job.large[unit / bands];
    const auto band = static_cast<uint32_t>(unit % bands);
    const Sphere sphere = unpackSample(job.frame.samples[id], job.frame.grid);
    const PixelRect rect = sphereFootprint(job.footprint, sphere);
    const Splat splat = splatOf(job, sphere, id);
    const auto rows = static_cast<uint32_t>(rect.y1 - rect.y0);
    const uint32_t first = static_cast<uint32_t>(rect.y0) + static_cast<uint32_t>(uint64_t{rows} * band / bands);
    const uint32_t end = static_cast<uint32_t>(rect.y0) + static_cast<uint32_t>(uint64_t{rows} * (band + 1) / bands);
    const auto width = static_cast<uint32_t>(rect.x1 - rect.x0);
    for (uint32_t k = threadIdx.x; k < (end - first) * width; k += kThreads)
      splatPixel<true>(job, splat, static_cast<uint32_t>(rect.x0) + k % width, first + k / width);
  }
}

__global__ void resolveNearest(const unsigned long long* nearest, size_t pixels, uint32_t* ids, float* depth) {
  const size_t i = size_t{blockIdx.x} * blockDim.x + threadIdx.x;
  if (i >= pixels) return;
  const unsigned long long value = nearest[i];
  ids[i] = value == kNothing ? kNoSample : static_cast<uint32_t>(value);
  if (depth != nullptr) depth[i] = value == kNothing ? kNoHit : __uint_as_float(static_cast<uint32_t>(value >> 32));
}

}  // namespace

void DeviceSplats::draw(const DeviceFrameView& frame, const Camera& camera, uint32_t* ids, float* depth, cudaStream_t stream) {
  const size_t pixels = size_t{camera.width} * camera.height;
  nearest_.reserve(pixels);
  large_.reserve(frame.count);
  WARPSCOPE_CUDA_CHECK(cudaMemsetAsync(nearest_.data(), 0xff, pixels * sizeof(unsigned long long), stream));
  WARPSCOPE_CUDA_CHECK(cudaMemsetAsync(largeCount_.data(), 0, sizeof(uint32_t), stream));
  if (frame.count > 0) {
    const glm::vec3 eye = glm::abs(camera.eye);
    SplatJob job{frame, camera, footprintViewOf(camera), 0.0f, pixelEdge(camera), nearest_.data(), large_.data(), largeCount_.data(), 1};
    const unsigned blocks = cuda::blocksFor(frame.count, kThreads);
    job.stride = strideFor(blocks);
    job.margin = kFootprintMargin * (eye.x + eye.y + eye.z + frame.reach());
    splatSamples<<<blocks, kThreads, 0, stream>>>(job);
    WARPSCOPE_CUDA_CHECK_LAUNCH();
    splatLarge<<<kLargeBlocks, kThreads, 0, stream>>>(job);
    WARPSCOPE_CUDA_CHECK_LAUNCH();
  }
  constexpr unsigned kResolveThreads = 256;
  resolveNearest<<<cuda::blocksFor(pixels, kResolveThreads), kResolveThreads, 0, stream>>>(nearest_.data(), pixels, ids, depth);
  WARPSCOPE_CUDA_CHECK_LAUNCH();
}

}  // namespace warpscope
