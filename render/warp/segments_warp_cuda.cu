// Field, light and walks on the device.
// See segments_warp_cuda.h.
#include "render/warp/segments_warp_cuda.h"

#include <type_traits>

#include "render/cuda/pixel_tiles.cuh"
#include "render/warp/device/device_proxy.h"
#include "render/warp/device/device_warp.h"
#include "render/warp/fill.h"
#include "render/warp/proxy_fill.h"
#include "render/warp/segments/device_segment_field.h"
#include "render/warp/segments/segment_walk.h"
#include "render/warp/segments_warp.h"

namespace warpscope {
namespace {

/// Makes nothing of what is not known.
struct NoMarch {};

/// Not inlined: a ray marches a few pieces, and walks through hundreds of cells, for which registers are better used.
template <class March>
__device__ __noinline__ RayLight lightOfPiece(const March& march, const Ray& ray, float tNear, float tFar, float through) {
  return march(ray, tNear, tFar, through);
}

template <class March>
struct FillBy {
  const March& march;
  const Ray& ray;
  __device__ void operator()(WalkedRay& walked, float tNear, float tFar) const {
    if constexpr (!std::is_same_v<March, NoMarch>) {
      const RayLight light = lightOfPiece(march, ray, tNear, tFar, walked.through);
      walked.guess(glm::vec3(light.color), static_cast<float>(1.0 - light.transmittance));
    }
  }
};

/// Of a multiprocessor, that there are registers for. Measured on an H200: more blocks make walks spill, fewer leave loads to wait for.
template <class March>
constexpr int kBlocksAtOnce = std::is_same_v<March, NoMarch> ? 7 : 4;

/// What all rays of a picture share.
struct Picture {
  SegmentField field;
  PixelGrid pixels;
  Box bounds;
  uint32_t width = 0, height = 0;
  float stopBelow = 0.0f;
};

template <bool kIsLinear, class March>
__global__ void __launch_bounds__(kTileBlockThreads, kBlocksAtOnce<March>) walkPixels(const __grid_constant__ Picture picture, const __grid_constant__ March march, DevicePixels out) {
  const PixelPlace pixel = pixelOfThread(0);
  if (pixel.x >= picture.width || pixel.y >= picture.height) return;
  const Ray ray = picture.pixels.ray(pixel.x, pixel.y).ray;
  const RayInterval inside = intersectBox(reciprocalOf(ray.origin, ray.direction), picture.bounds, 0.0f, std::numeric_limits<float>::infinity());
  WalkedRay walked;
  if (!inside.isMiss()) walked = walkSegments<kIsLinear>(picture.field, ray, inside.tNear, inside.tFar, picture.stopBelow, FillBy<March>{march, ray});
  const size_t i = size_t{pixel.y} * picture.width + pixel.x;
  out.color[i] = walked.seen();
  out.samples[i] = walked.id();
}

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
    const RenderSettings& marched = head.settings.render;
    picture.stopBelow = marched.terminateEarly ? marched.contribution : 0.0f;
    const bool isLinear = settings.knobs.choice<Between>(kBetweenKnob) == Between::linear;
    const auto walk = [&](const auto& march) {
      const dim3 grid = tileGrid(camera.width, camera.height);
      if (isLinear)
        walkPixels<true><<<grid, kTileBlockThreads, 0, stream>>>(picture, march, pixels);
      else
        walkPixels<false><<<grid, kTileBlockThreads, 0, stream>>>(picture, march, pixels);
      WARPSCOPE_CUDA_CHECK_LAUNCH();
    };
    if (!head.proxy || fillOf(kSegmentsWarp, settings.knobs) != Fill::proxy) return walk(NoMarch{});
    fill_.visit(head.proxy, marched, camera, [&](const auto& march, const auto& baked) { deviceProxy_.visit(head.proxy, march, baked, stream, walk); });
  }

  DeviceSegmentField field_;
  ProxyFill fill_;
  DeviceProxy deviceProxy_;
};

}  // namespace

std::unique_ptr<Warp> makeCudaSegmentsWarp() { return std::make_unique<CudaSegmentsWarp>(); }

}  // namespace warpscope
