// The first surfaces along each pixel's ray without a hierarchy: pieces of samples' spheres are kept by footprint, and gaps between surfaces closed by spheres of the frame's own radii
// where there are any. The same pictures as of SurfaceTracer, by the same formulas (surface_hits.h). For .cu files.
#pragma once

#include "render/warp/device/device_warp.h"
#include "render/warp/multihit/device_samples.cuh"
#include "render/warp/multihit/piece_footprint.h"
#include "render/warp/multihit/surface_hits.h"
#include "render/warp/splats/footprint_walk.cuh"

namespace warpscope {

/// Pieces of spheres, of which the nearest are kept.
template <int kPieces>
struct NearestPieces {
  static constexpr int kKept = kPieces;
  static constexpr bool kAreAlike = false;  // seen from aside, some pieces are many times as long as others
  SamplesOnDevice frame;
  glm::vec3 origin;    ///< from the frame's eye to the rays'
  bool isOrthonormal;  ///< the frame's camera

  __device__ PixelRect footprintOf(const FootprintView& view, uint32_t id, const Sphere& sphere) const {
    const PixelRect whole = sphereFootprint(view, sphere);
    return isOrthonormal ? pieceFootprint(view, frame.grid, frame.samples[id], origin, sphere, whole) : whole;
  }
  __device__ float distanceOf(uint32_t id, const glm::vec3& direction, const glm::vec3& toCenter, float t) const {
    return pieceDistance(frustumOf(frame.grid.pixels, frame.samples[id], origin), direction, toCenter, t);
  }
};

/// A pixel's kept hits as surfacesOf() wants them.
template <int kPieces>
struct KeptPieces {
  uint32_t ids[kPieces];
  __device__ KeptPieces(const HitPlanes& planes, size_t at) {
    for (int k = 0; k < kPieces; ++k) ids[k] = static_cast<uint32_t>(planes.hits[k * planes.size() + at]);
    static_assert(kNoSample == static_cast<uint32_t>(kNoKeptHit));
  }
  __device__ uint32_t id(int i) const {
    uint32_t found = kNoSample;  // in registers: no index that is known only later
    for (int k = 0; k < kPieces; ++k) found = k == i ? ids[k] : found;
    return found;
  }
};

constexpr unsigned kSurfaceThreads = 256;

/// Colours what shows surfaces; the others' places in `nearest` become free for a hit, and their tiles wanted.
template <int kSurfaces>
__global__ void __launch_bounds__(kSurfaceThreads) resolvePieces(const __grid_constant__ HitPlanes pieces, const __grid_constant__ SamplesOnDevice frame, const __grid_constant__ Camera camera,
                                                                 DevicePixels pixels, HitPlanes nearest, uint8_t* isWanted, uint32_t tilesInRow) {
  constexpr int kPieces = piecesFor(kSurfaces);
  const uint32_t i = blockIdx.x * kSurfaceThreads + threadIdx.x;
  if (i >= camera.width * camera.height) return;
  const uint32_t x = i % camera.width, y = i / camera.width;
  const SurfacesSeen seen = surfacesOf(frame, rayOfPixel(camera, {x, y}), KeptPieces<kPieces>(pieces, pieces.at(x, y)), kPieces, kSurfaces);
  pixels.samples[i] = seen.nearest;
  pixels.color[i] = seen.color;
  const bool isGap = seen.nearest == kNoSample;
  nearest.hits[nearest.at(x, y)] = isGap ? kNoKeptHit : 0;  // nothing is nearer than 0
  if (isGap) isWanted[y / WantedTiles::kSide * tilesInRow + x / WantedTiles::kSide] = 1;
}

static __global__ void __launch_bounds__(kSurfaceThreads) closeGaps(const __grid_constant__ HitPlanes nearest, const __grid_constant__ SamplesOnDevice frame, const __grid_constant__ SampleRays rays,
                                                                    const __grid_constant__ Camera frameCamera, const __grid_constant__ Camera camera, DevicePixels pixels) {
  const uint32_t i = blockIdx.x * kSurfaceThreads + threadIdx.x;
  if (i >= camera.width * camera.height) return;
  const uint32_t x = i % camera.width, y = i / camera.width;
  const KeptHit hit = nearest.hits[nearest.at(x, y)];
  if (hit == 0 || hit == kNoKeptHit) return;
  if (isSeenEmpty(rays, frameCamera, rayOfPixel(camera, {x, y}).at(__uint_as_float(static_cast<uint32_t>(hit >> 32))))) return;
  const auto id = static_cast<uint32_t>(hit);
  pixels.samples[i] = id;
  pixels.color[i] = frame.color(id);
}

class SplattedSurfaces {
 public:
  /// Device memory that a picture takes.
  static size_t bytesFor(const Camera& camera, int surfaces) { return planesFor(camera).size() * (static_cast<size_t>(piecesFor(surfaces)) + 1) * sizeof(KeptHit); }

  /// `closed`: the frame with the radii of pieces, which `samples` has too; `wide`: with its own. In stream order, without waiting and, once the buffers have their size, without allocating.
  template <int kSurfaces>
  void draw(const DeviceFrameView& closed, const DeviceFrameView& wide, const SamplesOnDevice& samples, const SampleRays& rays, const Camera& frameCamera, const Camera& camera,
            const DevicePixels& pixels, cudaStream_t stream) {
    constexpr int kPieces = piecesFor(kSurfaces);
    HitPlanes pieces = planesFor(camera), nearest = pieces;
    hits_.reserve(bytesFor(camera, kSurfaces) / sizeof(KeptHit));
    nearest.hits = hits_.data();
    pieces.hits = hits_.data() + pieces.size();
    const auto tiles = [](uint32_t length) { return (length - 1) / WantedTiles::kSide + 1; };
    const size_t tileCount = size_t{tiles(camera.width)} * tiles(camera.height);
    isWanted_.reserve(tileCount);
    WARPSCOPE_CUDA_CHECK(cudaMemsetAsync(pieces.hits, 0xff, kPieces * pieces.size() * sizeof(KeptHit), stream));
    WARPSCOPE_CUDA_CHECK(cudaMemsetAsync(isWanted_.data(), 0, tileCount, stream));
    walk_.walk(NearestPieces<kPieces>{samples, camera.eye - frameCamera.eye, isOrthonormal(frameCamera)}, closed, camera, pieces, {}, stream);
    const unsigned blocks = cuda::blocksFor(size_t{camera.width} * camera.height, kSurfaceThreads);
    resolvePieces<kSurfaces><<<blocks, kSurfaceThreads, 0, stream>>>(pieces, samples, camera, pixels, nearest, isWanted_.data(), tiles(camera.width));
    WARPSCOPE_CUDA_CHECK_LAUNCH();
    walk_.walk(NearestInGaps{}, wide, camera, nearest, {isWanted_.data(), tiles(camera.width)}, stream);
    closeGaps<<<blocks, kSurfaceThreads, 0, stream>>>(nearest, samples, rays, frameCamera, camera, pixels);
    WARPSCOPE_CUDA_CHECK_LAUNCH();
  }

 private:
  cuda::DeviceBuffer<KeptHit> hits_;  // the nearest of wide spheres, then pieces
  cuda::DeviceBuffer<uint8_t> isWanted_;
  FootprintWalk walk_;
};

}  // namespace warpscope
