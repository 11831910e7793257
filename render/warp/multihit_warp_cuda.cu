// Surfaces along each ray, by footprints or through hierarchies, their pieces then kept in registers; and their colours over one another.
// See multihit_warp_cuda.h. What SurfaceTracer does on the host, by the same formulas (multihit/surface_hits.h).
#include "render/warp/multihit_warp_cuda.h"

#include <array>
#include <stdexcept>
#include <utility>

#include "render/warp/clusters/cluster_trace.cuh"
#include "render/warp/clusters/cluster_tree.h"
#include "render/warp/device/device_warp.h"
#include "render/warp/device/sphere_samples.h"
#include "render/warp/sphere_ways.h"
#include "render/warp/multihit/splatted_surfaces.cuh"
#include "render/warp/multihit/surface_hits.h"
#include "render/warp/multihit_warp.h"

namespace warpscope {
namespace {

constexpr unsigned kHitThreads = 256;

/// Of rays in one pixel the one whose first sample is nearest, of equally near ones the first, as ownPicture(): `firstOf` takes its depth code and, in the lower half, its index.
__global__ void findFirstSamples(const SampleRays rays, unsigned long long* firstOf) {
  const uint32_t i = blockIdx.x * kHitThreads + threadIdx.x;
  if (i >= rays.count || (rays.layers != nullptr && rays.layers[i] != 0)) return;
  const PackedSample sample = rays.samples[i];
  const uint32_t column = columnOf(sample), row = rowOf(sample);
  if (column >= rays.width || row >= rays.height) return;
  atomicMin(&firstOf[size_t{row} * rays.width + column], static_cast<unsigned long long>(depthCode(sample)) << 32 | i);
}

__global__ void keepIndices(const unsigned long long* firstOf, uint32_t* indices, size_t count) {
  const size_t i = size_t{blockIdx.x} * kHitThreads + threadIdx.x;
  static_assert(kNoSample == 0xffffffffu, "what no sample has set");
  if (i < count) indices[i] = static_cast<uint32_t>(firstOf[i]);
}

__global__ void setSurfaceRadii(const __grid_constant__ SampleRays rays, PackedSample* samples) {
  const uint32_t i = blockIdx.x * kHitThreads + threadIdx.x;
  if (i < rays.count) samples[i] = withSurfaceRadius(rays, i);
}

/// A ray's pieces as traceClusters wants them.
template <int Pieces>
struct GatheredPieces {
  const SamplesOnDevice& frame;
  const ClusterTreeView& tree;
  Ray ray;
  glm::vec3 origin;  ///< from the frame's eye to the ray's
  bool isWanted;     ///< false for a pixel outside the image
  NearestHits<Pieces> nearest;

  __device__ float farthest() const { return isWanted ? nearest.farthest() : -1.0f; }
  __device__ void add(uint32_t place, float t) {
    const uint32_t id = tree.ids[place];
    const float4 sphere = tree.spheres[place];
    const glm::vec3 toCenter = glm::vec3(sphere.x, sphere.y, sphere.z) - ray.origin;
    nearest.insert(pieceDistance(frustumOf(frame.grid.pixels, frame.samples[id], origin), ray.direction, toCenter, t), id);
  }
};

/// The nearest of all spheres, as traceClusters wants it.
struct GatheredHit {
  const uint32_t* ids;
  bool isWanted;
  NearestHits<1> nearest;

  __device__ float farthest() const { return isWanted ? nearest.farthest() : -1.0f; }
  __device__ void add(uint32_t place, float t) { nearest.insert(t, ids[place]); }
};

template <int Surfaces>
__global__ void __launch_bounds__(kTileBlockThreads)
    traceSurfaces(const __grid_constant__ ClusterTreeView pieces, const __grid_constant__ ClusterTreeView wide, const __grid_constant__ SamplesOnDevice frame,
                  const __grid_constant__ SampleRays rays, const __grid_constant__ Camera frameCamera, const __grid_constant__ Camera camera, DevicePixels pixels) {
  constexpr int kPieces = piecesFor(Surfaces);
  __shared__ ClusterWarpMemory memory[kTilesPerBlock];
  const PixelPlace tile = tileOfThread(0);
  if (tile.x >= camera.width || tile.y >= camera.height) return;  // the whole warp
  const PixelPlace pixel = pixelOfThread(0);
  const bool isInside = pixel.x < camera.width && pixel.y < camera.height;
  const Ray ray = rayOfPixel(camera, pixel);
  const glm::vec3 directions[1] = {ray.direction};
  GatheredPieces<kPieces> gathered[1] = {{frame, pieces, ray, camera.eye - frameCamera.eye, isInside, {}}};
  traceClusters(pieces, camera, tile, directions, memory[threadIdx.x / 32], gathered);
  SurfacesSeen seen;
  if (isInside) seen = surfacesOf(frame, ray, gathered[0].nearest, kPieces, Surfaces);
  const bool isGap = isInside && seen.nearest == kNoSample;
  if (__any_sync(kAllLanes, isGap)) {
    GatheredHit hit[1] = {{wide.ids, isGap, {}}};
    traceClusters(wide, camera, tile, directions, memory[threadIdx.x / 32], hit);
    const uint32_t id = hit[0].nearest.id(0);
    if (isGap && id != kNoSample && !isSeenEmpty(rays, frameCamera, ray.at(hit[0].nearest.t(0)))) seen = {id, frame.color(id)};
  }
  if (!isInside) return;
  const size_t i = size_t{pixel.y} * camera.width + pixel.x;
  pixels.samples[i] = seen.nearest;
  pixels.color[i] = seen.color;
}

/// What both ways want.
struct Job {
  const SamplesOnDevice& frame;
  const SampleRays& rays;
  const Camera& frameCamera;
  const Camera& camera;
  const DevicePixels& pixels;
};

template <int Surfaces>
void launchTrace(const ClusterTreeView& pieces, const ClusterTreeView& wide, const Job& job, cudaStream_t stream) {
  traceSurfaces<Surfaces><<<tileGrid(job.camera.width, job.camera.height), kTileBlockThreads, 0, stream>>>(pieces, wide, job.frame, job.rays, job.frameCamera, job.camera, job.pixels);
  WARPSCOPE_CUDA_CHECK_LAUNCH();
}

template <int Surfaces>
void splatSurfaces(SplattedSurfaces& splatted, const DeviceFrameView& closed, const DeviceFrameView& wide, const Job& job, cudaStream_t stream) {
  splatted.draw<Surfaces>(closed, wide, job.frame, job.rays, job.frameCamera, job.camera, job.pixels, stream);
}

/// For 1 .. kMaxHits surfaces.
template <int... Surfaces>
constexpr auto tracersFor(std::integer_sequence<int, Surfaces...>) {
  return std::array{&launchTrace<Surfaces + 1>...};
}
constexpr auto kTracers = tracersFor(std::make_integer_sequence<int, kMaxHits>());
template <int... Surfaces>
constexpr auto splattersFor(std::integer_sequence<int, Surfaces...>) {
  return std::array{&splatSurfaces<Surfaces + 1>...};
}
constexpr auto kSplatters = splattersFor(std::make_integer_sequence<int, kMaxHits>());

class CudaMultihitWarp final : public DeviceWarp {
 public:
  explicit CudaMultihitWarp(SphereTracing way) : way_(way) {
    if (way != SphereTracing::automatic && way != SphereTracing::footprints && way != SphereTracing::clusters)
      throw std::invalid_argument("surfaces are found by footprints or through clusters");
  }

 private:
  bool blends() const override { return true; }

  void upload(const SampleFrame& frame, cudaStream_t stream) override {
    DeviceWarp::upload(frame, stream);
    camera_ = frame.camera;
    hasUploadedLayers_ = frameThere().layers() == nullptr && !frame.layers().empty();
    if (hasUploadedLayers_) layers_.upload(frame.layers(), stream);
    probe_ = spheres_.probeOf(frame, frameThere().view(), stream);
    isReady_ = haveTrees_ = false;
  }

  bool prepare(const WarpSettings& settings, const Camera& camera) override {
    isSplatted_ = isSplatted(camera, hitsOf(settings));
    return !isSplatted_ && !haveTrees_;
  }

  void build(const DeviceFrameView& frame, const WarpSettings&, cudaStream_t stream) override {
    if (!isReady_) return makeReady(frame, stream);
    wide_.build(frame, stream);
    pieces_.build(closed_, stream);
    haveTrees_ = true;
  }

  /// What both ways want. Hierarchies stand when a picture wants them.
  void makeReady(const DeviceFrameView& frame, cudaStream_t stream) {
    const size_t pixels = size_t{camera_.width} * camera_.height;
    nearestOf_.reserve(pixels);
    firstOf_.reserve(pixels);
    rays_ = {frame.samples, hasUploadedLayers_ ? layers_.data() : frameThere().layers(), firstOf_.data(), frame.count, camera_.width, camera_.height, frame.grid};
    WARPSCOPE_CUDA_CHECK(cudaMemsetAsync(nearestOf_.data(), 0xff, pixels * sizeof(unsigned long long), stream));
    if (frame.count > 0) {
      findFirstSamples<<<cuda::blocksFor(frame.count, kHitThreads), kHitThreads, 0, stream>>>(rays_, nearestOf_.data());
      WARPSCOPE_CUDA_CHECK_LAUNCH();
    }
    keepIndices<<<cuda::blocksFor(pixels, kHitThreads), kHitThreads, 0, stream>>>(nearestOf_.data(), firstOf_.data(), pixels);
    WARPSCOPE_CUDA_CHECK_LAUNCH();
    samples_.reserve(frame.count);
    if (frame.count > 0) {
      setSurfaceRadii<<<cuda::blocksFor(frame.count, kHitThreads), kHitThreads, 0, stream>>>(rays_, samples_.data());
      WARPSCOPE_CUDA_CHECK_LAUNCH();
    }
    closed_ = frame;
    closed_.samples = samples_.data();
    isReady_ = true;
  }

  void trace(const DeviceFrameView& frame, const Camera& camera, const WarpSettings& settings, const DevicePixels& pixels,
             cudaStream_t stream) override {
    const SamplesOnDevice samples{samples_.data(), frame.colors, colorTables(), frame.grid};
    const Job job{samples, rays_, camera_, camera, pixels};
    const auto instance = static_cast<size_t>(hitsOf(settings) - 1);
    if (isSplatted_)
      kSplatters[instance](splatted_, closed_, frame, job, stream);
    else
      kTracers[instance](pieces_.view(), wide_.view(), job, stream);
  }

  bool isSplatted(const Camera& camera, int surfaces) const {
    if (way_ != SphereTracing::automatic) return way_ == SphereTracing::footprints;
    return SplattedSurfaces::bytesFor(camera, surfaces) <= kMostSplatBytes && surfaceCosts(probe_.loadFor(camera), surfaces).favourFootprints();
  }

  static int hitsOf(const WarpSettings& settings) { return settings.knobs.whole(kHitsKnob); }

  /// Beyond, hierarchies take less memory.
  static constexpr size_t kMostSplatBytes = size_t{1} << 30;

  const SphereTracing way_;
  Camera camera_;  // the frame's
  bool hasUploadedLayers_ = false;
  SampleRays rays_;  // in device memory
  cuda::DeviceBuffer<uint8_t> layers_;
  cuda::DeviceBuffer<unsigned long long> nearestOf_;
  cuda::DeviceBuffer<uint32_t> firstOf_;
  cuda::DeviceBuffer<PackedSample> samples_;  // with the radii of pieces
  DeviceFrameView closed_;                  // of them
  DeviceClusterTree pieces_, wide_;
  SplattedSurfaces splatted_;
  SphereSamples spheres_;
  SphereLoadProbe probe_;
  bool isReady_ = false, haveTrees_ = false;  // of the frame
  bool isSplatted_ = false;  // the picture being made
};

}  // namespace

std::unique_ptr<Warp> makeCudaMultihitWarp(SphereTracing way) { return std::make_unique<CudaMultihitWarp>(way); }

}  // namespace warpscope
