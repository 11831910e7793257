// A field that the host builds, copied; light and walks on the device.
// See segments_warp_cuda.h.
#include "render/warp/segments_warp_cuda.h"

#include "render/cuda/pixel_tiles.cuh"
#include "render/warp/device/device_warp.h"
#include "render/warp/proxy_fill.h"
#include "render/warp/segments/segment_field_build.h"
#include "render/warp/segments/segment_light.h"
#include "render/warp/segments/segment_walk.h"
#include "render/warp/segments_warp.h"

namespace warpscope {
namespace {

/// Makes nothing of what is not known.
struct NoMarch {
  __device__ RayLight operator()(const Ray&, float, float, float) const { return {}; }
};

template <class March>
struct FillBy {
  const March& march;
  const Ray& ray;
  __device__ void operator()(WalkedRay& walked, float tNear, float tFar) const {
    const RayLight light = march(ray, tNear, tFar, walked.through);
    walked.pass(glm::vec3(light.color), static_cast<float>(1.0 - light.transmittance));
  }
};

/// What all rays of a picture share.
struct Picture {
  SegmentField field;
  PixelGrid pixels;
  Box bounds;
  uint32_t width = 0, height = 0;
  float stopBelow = 0.0f;
};

template <bool kIsLinear, class March>
__global__ void __launch_bounds__(kTileBlockThreads) walkPixels(const __grid_constant__ Picture picture, const __grid_constant__ March march, DevicePixels out) {
  const PixelPlace pixel = pixelOfThread(0);
  if (pixel.x >= picture.width || pixel.y >= picture.height) return;
  const Ray ray = picture.pixels.ray(pixel.x, pixel.y).ray;
  const RayInterval inside = intersectBox(reciprocalOf(ray.origin, ray.direction), picture.bounds, 0.0f, std::numeric_limits<float>::infinity());
  WalkedRay walked;
  if (!inside.isMiss()) walked = walkSegments<kIsLinear>(picture.field, ray, inside.tNear, inside.tFar, picture.stopBelow, FillBy<March>{march, ray});
  const float opacity = 1.0f - walked.through;
  const size_t i = size_t{pixel.y} * picture.width + pixel.x;
  out.color[i] = glm::vec4(walked.color, opacity);
  out.samples[i] = opacity > 0.0f ? kNotASample : kNoSample;
}

/// A thread a pixel of the frame.
__global__ void __launch_bounds__(kTileBlockThreads)
    relightPixels(const __grid_constant__ SegmentField field, FieldSegment* segments, const glm::vec3* unlit, const NormalCode* normals,
                  const __grid_constant__ ShadingSetup lights, glm::vec3 eye) {
  const PixelPlace pixel = pixelOfThread(0);
  if (pixel.x >= static_cast<uint32_t>(field.width) || pixel.y >= static_cast<uint32_t>(field.height)) return;
  const size_t at = size_t{pixel.y} * static_cast<size_t>(field.width) + pixel.x;
  for (uint32_t i = field.first[at] & ~SegmentField::kEndedBit; i < (field.first[at + 1] & ~SegmentField::kEndedBit); ++i)
    if (normals[i] != 0) segments[i].color = relitColor(lightOf(segments[i], normals[i], field.pixels, pixel.x, pixel.y, lights, eye), unlit[i]);
}

/// The copy of the volume, and how its values look, in device memory.
class DeviceProxy {
 public:
  /// Calls f(march) with `march`, which ProxyFill gave, by pointers to copies of what it points to.
  template <class March, class F>
  void visit(const ProxyPtr& proxy, March march, const std::shared_ptr<const BakedTransfer>& baked, cudaStream_t stream, const F& f) {
    if (proxy != proxy_) voxels_.upload({proxy->volume->voxelsAs<uint8_t>(), proxy->volume->voxelCount()}, stream);
    proxy_ = proxy;
    if (baked != baked_) {
      entries_.upload(baked->table.entries, stream);
      alphas_.upload(baked->table.alphas, stream);
      unitAlphas_.upload(baked->table.unitAlphas, stream);
      refinements_.upload(baked->table.refinements, stream);
      begins_.upload(baked->table.begins, stream);
      distances_.upload(baked->emptyDistances, stream);
      baked_ = baked;
    }
    march.view.voxels = voxels_.data();
    march.view.transfer.entries = entries_.data();
    march.view.transfer.alphas = alphas_.data();
    march.view.transfer.unitAlphas = unitAlphas_.data();
    march.view.transfer.refinements = refinements_.data();
    march.view.transfer.begins = begins_.data();
    march.view.cells.distances = distances_.data();
    f(march);
  }

 private:
  ProxyPtr proxy_;                              // whose voxels these are
  std::shared_ptr<const BakedTransfer> baked_;  // that the others are of
  cuda::DeviceBuffer<uint8_t> voxels_, distances_;
  cuda::DeviceBuffer<glm::vec4> entries_;
  cuda::DeviceBuffer<float> alphas_, unitAlphas_, begins_;
  cuda::DeviceBuffer<TransferRefinement> refinements_;
};

class CudaSegmentsWarp final : public DeviceWarp {
 private:
  bool blends() const override { return true; }

  void upload(const SampleFrame& frame, cudaStream_t stream) override {
    built_.build(frame);
    first_.upload(built_.first(), stream);
    segments_.upload(built_.segments(), stream);
    for (int level = 0; level < kFieldLevels; ++level) tiles_[level].upload(built_.tiles(level), stream);
    unlit_.upload(built_.unlit(), stream);
    normals_.upload(frame.segments.normals, stream);
    head_ = headOf(frame);
  }
  void build(const DeviceFrameView&, const WarpSettings&, cudaStream_t) override {}

  void trace(const DeviceFrameView&, const Camera& camera, const WarpSettings& settings, const DevicePixels& pixels, cudaStream_t stream) override {
    if (head_.settings.sample.segments == 0) {
      WARPSCOPE_CUDA_CHECK(cudaMemsetAsync(pixels.samples, 0xff, size_t{camera.width} * camera.height * sizeof(uint32_t), stream));
      WARPSCOPE_CUDA_CHECK(cudaMemsetAsync(pixels.color, 0, size_t{camera.width} * camera.height * sizeof(glm::vec4), stream));
      return;
    }
    Picture picture;
    picture.field = built_.field();
    picture.field.first = first_.data();
    picture.field.segments = segments_.data();
    for (int level = 0; level < kFieldLevels; ++level) picture.field.tiles[level] = tiles_[level].data();
    if (!built_.unlit().empty()) {
      const auto width = static_cast<uint32_t>(picture.field.width), height = static_cast<uint32_t>(picture.field.height);
      relightPixels<<<tileGrid(width, height), kTileBlockThreads, 0, stream>>>(picture.field, segments_.data(), unlit_.data(), normals_.data(),
                                                                               BuiltSegmentField::lightsFor(head_, camera), camera.eye);
      WARPSCOPE_CUDA_CHECK_LAUNCH();
    }
    picture.bounds = head_.quantization.bounds;
    picture.pixels = makePixelGrid(camera, depthRangeOf(camera, picture.bounds).nearDepth);
    picture.width = camera.width;
    picture.height = camera.height;
    const RenderSettings& marched = head_.settings.render;
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
    if (!head_.proxy) return walk(NoMarch{});
    fill_.visit(head_.proxy, marched, camera, [&](const auto& march, const auto& baked) { deviceProxy_.visit(head_.proxy, march, baked, stream, walk); });
  }

  /// The frame without what it holds.
  static SampleFrame headOf(const SampleFrame& frame) {
    SampleFrame head;
    head.camera = frame.camera;
    head.quantization = frame.quantization;
    head.settings = frame.settings;
    head.proxy = frame.proxy;
    return head;
  }

  SampleFrame head_;
  BuiltSegmentField built_;
  ProxyFill fill_;
  DeviceProxy deviceProxy_;
  cuda::DeviceBuffer<uint32_t> first_;
  cuda::DeviceBuffer<FieldSegment> segments_;
  cuda::DeviceBuffer<FieldTile> tiles_[kFieldLevels];
  cuda::DeviceBuffer<glm::vec3> unlit_;
  cuda::DeviceBuffer<NormalCode> normals_;
};

}  // namespace

std::unique_ptr<Warp> makeCudaSegmentsWarp() { return std::make_unique<CudaSegmentsWarp>(); }

}  // namespace warpscope
