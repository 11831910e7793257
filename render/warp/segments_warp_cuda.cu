// Field, light and walks on the device.
// See segments_warp_cuda.h.
#include "render/warp/segments_warp_cuda.h"

#include <algorithm>

#include "render/cuda/pixel_tiles.cuh"
#include "render/warp/device/device_proxy.h"
#include "render/warp/device/device_warp.h"
#include "render/warp/proxy_fill.h"
#include "render/warp/segments/device_segment_field.h"
#include "render/warp/segments/segment_walk.h"
#include "render/warp/segments_warp.h"

namespace warpscope {
namespace {

/// What all rays of a picture share.
struct Picture {
  SegmentField field;
  PixelGrid pixels;
  Box bounds;
  uint32_t width = 0, height = 0;
  float stopBelow = 0.0f;
};

/// Rays whose walks were interrupted: where their pixels are in the picture, and how far they came, both by the order in which they were.
struct Interrupted {
  uint32_t* count;
  uint32_t* pixels;
  InterruptedWalk* walks;
};

__device__ inline void store(const DevicePixels& out, size_t i, const WalkedRay& walked) {
  out.color[i] = walked.seen();
  out.samples[i] = walked.id();
}

/// Of a multiprocessor, that there are registers for. Measured on an H200 and an H100: more blocks make walks spill, fewer leave loads to wait for.
template <Between kBetween>
constexpr int kBlocksThatWalk = kBetween == Between::refined ? 5 : kBetween == Between::linear ? 7 : 8;
constexpr int kBlocksThatFill = 4;

/// Warps are tiles of 4 x 8 pixels side by side, because rays that are turned sideways go along the frame's rows, and are alike where they are next to each other on
/// a column. Blocks of the middle rows come first, whose rays are the longest.
constexpr unsigned kWalkWidth = 4, kWalkHeight = 8;
dim3 walkGrid(uint32_t width, uint32_t height) { return {cuda::blocksFor(width, kWalkWidth * kTilesPerBlock), cuda::blocksFor(height, kWalkHeight), 1}; }
__device__ inline PixelPlace pixelOfWalk() {
  const unsigned lane = threadIdx.x % 32, tile = blockIdx.x * kTilesPerBlock + threadIdx.x / 32, middle = (gridDim.y - 1) / 2, away = (blockIdx.y + 1) / 2;
  const unsigned row = blockIdx.y % 2 == 1 ? middle + away : middle - away;
  return {tile * kWalkWidth + lane % kWalkWidth, row * kWalkHeight + lane / kWalkWidth};
}

/// Nothing is made of what is not known.
template <Between kBetween>
__global__ void __launch_bounds__(kTileBlockThreads, kBlocksThatWalk<kBetween>) walkPixels(const __grid_constant__ Picture picture, DevicePixels out) {
  const PixelPlace pixel = pixelOfWalk();
  if (pixel.x >= picture.width || pixel.y >= picture.height) return;
  const Ray ray = picture.pixels.ray(pixel.x, pixel.y).ray;
  const RayInterval inside = partInside(picture.bounds, ray);
  WalkedRay walked;
  if (!inside.isMiss()) walked = walkSegments<kBetween>(picture.field, ray, inside.tNear, inside.tFar, picture.stopBelow);
  store(out, size_t{pixel.y} * picture.width + pixel.x, walked);
}

/// All rays as far as the frame knows.
template <Between kBetween>
__global__ void __launch_bounds__(kTileBlockThreads, kBlocksThatWalk<kBetween>)
    walkKnownPixels(const __grid_constant__ Picture picture, DevicePixels out, const __grid_constant__ Interrupted interrupted) {
  const PixelPlace pixel = pixelOfWalk();
  if (pixel.x >= picture.width || pixel.y >= picture.height) return;
  const Ray ray = picture.pixels.ray(pixel.x, pixel.y).ray;
  const RayInterval inside = partInside(picture.bounds, ray);
  InterruptedWalk walk;
  const uint32_t i = pixel.y * picture.width + pixel.x;
  if (inside.isMiss() || walkKnown<kBetween>(picture.field, ray, inside.tNear, inside.tFar, picture.stopBelow, walk)) return store(out, i, walk.walked);
  const uint32_t place = atomicAdd(interrupted.count, 1u);  // the compiler asks once for all lanes
  interrupted.pixels[place] = i;
  interrupted.walks[place] = walk;
}

/// Of those that were interrupted the rest. Rays of a warp walk, and then all that have to march through the copy. That march is not inlined: a ray marches a few pieces,
/// and walks through many cells, for which registers are better used.
template <class March>
__device__ __noinline__ RayLight lightOfPiece(const March& march, const Ray& ray, float tNear, float tFar, float through) {
  return march(ray, tNear, tFar, through);
}
template <Between kBetween, class March>
__global__ void __launch_bounds__(kTileBlockThreads, kBlocksThatFill)
    walkRests(const __grid_constant__ Picture picture, const __grid_constant__ March march, DevicePixels out, const __grid_constant__ Interrupted interrupted) {
  const uint32_t count = *interrupted.count;
  for (uint32_t place = blockIdx.x * kTileBlockThreads + threadIdx.x; place < count; place += gridDim.x * kTileBlockThreads) {
    const uint32_t i = interrupted.pixels[place];
    const Ray ray = picture.pixels.ray(i % picture.width, i / picture.width).ray;
    const RayInterval inside = partInside(picture.bounds, ray);
    store(out, i,
          walkRest<kBetween>(picture.field, ray, inside.tNear, inside.tFar, picture.stopBelow, interrupted.walks[place], [&](WalkedRay& walked, float tNear, float tFar, FillReason reason) {
            walked.fill(lightOfPiece(march, ray, tNear, tFar, walked.through), reason);
          }));
  }
}

/// Of walkRests(): as many as run at once on any device, about.
constexpr unsigned kMostBlocks = 2048;

class CudaSegmentsWarp final : public DeviceWarp {
 private:
  bool blends() const override { return true; }

  void upload(const SampleFrame& frame, cudaStream_t stream) override { field_.upload(frame, stream); }
  void build(const DeviceFrameView&, const WarpSettings&, cudaStream_t stream) override { field_.build(colorTables(), stream); }

  void trace(const DeviceFrameView&, const Camera& camera, const WarpSettings& settings, const DevicePixels& pixels, cudaStream_t stream) override {
    if (field_.empty()) return clearPixels(camera, pixels, stream);
    field_.relight(camera, stream);
    const SampleFrame& head = field_.head();
    Picture picture;
    picture.field = field_.field();
    picture.bounds = head.quantization.bounds;
    picture.pixels = makePixelGrid(camera, depthRangeOf(camera, picture.bounds).nearDepth);
    picture.width = camera.width;
    picture.height = camera.height;
    picture.stopBelow = limitsOf(head.settings.render).stopBelow;
    visitBetween(betweenOf(head, camera, settings.knobs), [&](auto between) { walk<between()>(picture, camera, settings, pixels, stream); });
  }

  template <Between kBetween>
  void walk(const Picture& picture, const Camera& camera, const WarpSettings& settings, const DevicePixels& pixels, cudaStream_t stream) {
    const SampleFrame& head = field_.head();
    const dim3 grid = walkGrid(camera.width, camera.height);
    if (!isFilledFromCopy(head, settings.knobs)) {
      walkPixels<unfilled(kBetween)><<<grid, kTileBlockThreads, 0, stream>>>(picture, pixels);
      WARPSCOPE_CUDA_CHECK_LAUNCH();
      return;
    }
    const size_t most = size_t{camera.width} * camera.height;
    count_.reserve(1);
    interruptedPixels_.reserve(most);
    walks_.reserve(most);
    const Interrupted interrupted{count_.data(), interruptedPixels_.data(), walks_.data()};
    WARPSCOPE_CUDA_CHECK(cudaMemsetAsync(count_.data(), 0, sizeof(uint32_t), stream));
    walkKnownPixels<kBetween><<<grid, kTileBlockThreads, 0, stream>>>(picture, pixels, interrupted);
    WARPSCOPE_CUDA_CHECK_LAUNCH();
    fill_.visit(head.proxy, head.settings.render, camera, [&](const auto& onHost, const auto& baked) {
      deviceProxy_.visit(head.proxy, onHost, baked, stream, [&](const auto& march) {
        walkRests<kBetween><<<std::min(cuda::blocksFor(most, kTileBlockThreads), kMostBlocks), kTileBlockThreads, 0, stream>>>(picture, march, pixels, interrupted);
        WARPSCOPE_CUDA_CHECK_LAUNCH();
      });
    });
  }

  DeviceSegmentField field_;
  ProxyFill fill_;
  DeviceProxy deviceProxy_;
  cuda::DeviceBuffer<uint32_t> count_, interruptedPixels_;
  cuda::DeviceBuffer<InterruptedWalk> walks_;
};

}  // namespace

std::unique_ptr<Warp> makeCudaSegmentsWarp() { return std::make_unique<CudaSegmentsWarp>(); }

}  // namespace warpscope
