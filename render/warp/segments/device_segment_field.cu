// A scan, a thread a pixel, a thread a tile.
// See device_segment_field.h.
#include "render/warp/segments/device_segment_field.h"

#include <thrust/iterator/counting_iterator.h>
#include <thrust/iterator/transform_iterator.h>
#include <cub/device/device_scan.cuh>

#include "render/cuda/pixel_tiles.cuh"
#include "render/warp/segments/segment_field_build.h"
#include "render/warp/segments/segment_light.h"

namespace warpscope {
namespace {

/// Of each pixel; none behind the last.
struct NumberAt {
  const RaySegmentCount* rays;
  size_t pixels;
  __host__ __device__ uint32_t operator()(size_t i) const { return i < pixels ? static_cast<uint32_t>(rays[i].count()) : 0; }
};

constexpr unsigned kFieldThreads = 256;

__global__ void __launch_bounds__(kFieldThreads) markEnds(const RaySegmentCount* rays, size_t pixels, uint32_t* first) {
  const size_t i = size_t{blockIdx.x} * kFieldThreads + threadIdx.x;
  if (i < pixels && rays[i].isEnded()) first[i + 1] |= SegmentField::kEndedBit;
}

/// A thread a pixel of the frame, as all below it.
__global__ void __launch_bounds__(kTileBlockThreads)
    fillField(const __grid_constant__ PixelGrid pixels, uint32_t width, uint32_t height, const uint32_t* first, const SegmentDepths* depths, const Rgba8* codes,
              const ColorTables* tables, const OpticalDepths* opticalDepths, const __grid_constant__ FieldDepths fieldDepths, float colorScale, FieldSpan* spans,
              FieldMatter* matter, float* places, FieldTile* ofPixels) {
  const PixelPlace pixel = pixelOfThread(0);
  if (pixel.x >= width || pixel.y >= height) return;
  const size_t at = size_t{pixel.y} * width + pixel.x;
  const uint32_t begin = first[at] & ~SegmentField::kEndedBit, next = first[at + 1], end = next & ~SegmentField::kEndedBit;
  const float cosine = begin < end ? pixels.ray(pixel.x, pixel.y).cosine : 1.0f;
  FieldSegmentsOfPixel ofPixel(fieldDepths, *opticalDepths, cosine);
  FieldSpan outer[2];  // the first and the last
  SegmentDepths nextDepths = begin < end ? depths[begin] : SegmentDepths{};
  Rgba8 nextCode = begin < end ? codes[begin] : 0;
  for (uint32_t i = begin; i < end; ++i) {
    const SegmentDepths ownDepths = nextDepths;
    const Rgba8 code = nextCode;
    if (i + 1 < end) {  // does not wait for what is stored
      nextDepths = depths[i + 1];
      nextCode = codes[i + 1];
    }
    const FieldSegment segment = ofPixel.next(ownDepths, code);
    spans[i] = segment.span;
    matter[i] = {straightSegmentColor(*tables, code, colorScale), segment.extinction};
    places[i] = segment.place;
    if (i == begin) outer[0] = segment.span;
    outer[1] = segment.span;
  }
  ofPixels[at] = tileOf(outer, begin < end ? 2 : 0, (next & SegmentField::kEndedBit) != 0);
}

__global__ void __launch_bounds__(kFieldThreads) fillTiles(const FieldTile* parts, int partColumns, int partRows, int level, int columns, int rows, FieldTile* tiles) {
  const int i = static_cast<int>(blockIdx.x * kFieldThreads + threadIdx.x);
  if (i < columns * rows) tiles[i] = tileOf(parts, partColumns, partRows, level, i % columns, i / columns);
}

/// `to`: colours without the light (kUnlights), or in it.
template <bool kUnlights>
__global__ void __launch_bounds__(kTileBlockThreads)
    lightPixels(const __grid_constant__ SegmentField field, const FieldMatter* from, const NormalCode* normals, const __grid_constant__ ShadingSetup lights,
                glm::vec3 eye, FieldMatter* to) {
  const PixelPlace pixel = pixelOfThread(0);
  if (pixel.x >= static_cast<uint32_t>(field.width) || pixel.y >= static_cast<uint32_t>(field.height)) return;
  const size_t at = size_t{pixel.y} * static_cast<size_t>(field.width) + pixel.x;
  for (uint32_t i = field.first[at] & ~SegmentField::kEndedBit; i < (field.first[at + 1] & ~SegmentField::kEndedBit); ++i) {
    if (normals[i] == 0) continue;
    const LightFactors<float> factors = lightOf(field.places[i], normals[i], field.pixels, pixel.x, pixel.y, lights, eye);
    to[i].color = kUnlights ? unlit(factors, from[i].color) : relitColor(factors, from[i].color);
  }
}

/// The frame without what it holds.
SampleFrame headOf(const SampleFrame& frame) {
  SampleFrame head;
  head.camera = frame.camera;
  head.quantization = frame.quantization;
  head.settings = frame.settings;
  head.geometry = frame.geometry;
  head.proxy = frame.proxy;
  return head;
}

}  // namespace

void DeviceSegmentField::upload(const SampleFrame& frame, cudaStream_t stream) {
  head_ = headOf(frame);
  const FrameSegments& segments = frame.segments;
  const CudaFrame* const there = CudaFrame::of(frame);
  const bool isThere = there != nullptr && (frame.isAway || (there->sizes().rays == segments.rays.size() && there->sizes().segments == segments.size()));
  const size_t rays = isThere ? there->sizes().rays : segments.rays.size(), count = isThere ? there->sizes().segments : segments.size();
  width_ = rays == 0 ? 0 : static_cast<int>(frame.camera.width);
  height_ = rays == 0 ? 0 : static_cast<int>(frame.camera.height);
  hasNormals_ = isThere ? there->sizes().hasNormals : !segments.normals.empty();
  held_.reset();
  if (empty()) return;
  if (opticalDepths_.data() == nullptr) {
    const OpticalDepths depths = opticalDepths();
    opticalDepths_.upload({&depths, 1}, stream);
    WARPSCOPE_CUDA_CHECK(cudaStreamSynchronize(stream));  // `depths` goes
  }
  pixels_ = makePixelGrid(frame.camera, frame.quantization.nearDepth);
  fieldDepths_ = fieldDepthsOf(frame.quantization);
  if (isThere) held_ = frame.device;
  from_ = isThere ? &there->buffers() : &uploaded_;
  if (!isThere) {
    uploaded_.rays.upload(segments.rays, stream);
    uploaded_.depths.upload(segments.depths, stream);
    uploaded_.segmentColors.upload(segments.colors, stream);
    uploaded_.normals.upload(segments.normals, stream);
  }
  first_.reserve(rays + 1);
  // At least one place, so that there is memory to point to.
  spans_.reserve(count + SegmentField::kBeyond);
  matter_.reserve(count + 1);
  places_.reserve(count + 1);
  WARPSCOPE_CUDA_CHECK(cudaMemsetAsync(spans_.data() + count, 0, SegmentField::kBeyond * sizeof(FieldSpan), stream));
  if (count == 0) WARPSCOPE_CUDA_CHECK(cudaMemsetAsync(matter_.data(), 0, sizeof(FieldMatter), stream));  // walks look at one, whether there are any or not
  if (hasNormals_) unlit_.reserve(count + 1);
  ofPixels_.reserve(rays);
  for (int level = 0; level < kFieldLevels; ++level)
    tiles_[level].reserve(tileLevel(width_, height_, level).count());
}

void DeviceSegmentField::build(const ColorTables* tables, cudaStream_t stream) {
  if (empty()) return;
  const size_t pixels = static_cast<size_t>(width_) * static_cast<size_t>(height_);
  const auto numbers = thrust::make_transform_iterator(thrust::counting_iterator<size_t>(0), NumberAt{from_->rays.data(), pixels});
  cuda::withScratch(scratch_, [&](void* memory, size_t& bytes) {
    return cub::DeviceScan::ExclusiveSum(memory, bytes, numbers, first_.data(), static_cast<int64_t>(pixels + 1), stream);
  });
  markEnds<<<cuda::blocksFor(pixels, kFieldThreads), kFieldThreads, 0, stream>>>(from_->rays.data(), pixels, first_.data());
  WARPSCOPE_CUDA_CHECK_LAUNCH();
  const auto width = static_cast<uint32_t>(width_), height = static_cast<uint32_t>(height_);
  fillField<<<tileGrid(width, height), kTileBlockThreads, 0, stream>>>(pixels_, width, height, first_.data(), from_->depths.data(), from_->segmentColors.data(), tables,
                                                                       opticalDepths_.data(), fieldDepths_, segmentColorScale(hasNormals_), spans_.data(), matter_.data(), places_.data(),
                                                                       ofPixels_.data());
  WARPSCOPE_CUDA_CHECK_LAUNCH();
  for (int level = 0; level < kFieldLevels; ++level) {
    const TileLevel size = tileLevel(width_, height_, level);
    fillTiles<<<cuda::blocksFor(size.count(), kFieldThreads), kFieldThreads, 0, stream>>>(level == 0 ? ofPixels_.data() : tiles_[level - 1].data(), size.partColumns,
                                                                                          size.partRows, level, size.columns, size.rows, tiles_[level].data());
    WARPSCOPE_CUDA_CHECK_LAUNCH();
  }
  light<true>(head_.camera, stream);
}

void DeviceSegmentField::relight(const Camera& camera, cudaStream_t stream) { light<false>(camera, stream); }

template <bool kUnlights>
void DeviceSegmentField::light(const Camera& camera, cudaStream_t stream) {
  if (empty() || !hasNormals_) return;
  const auto width = static_cast<uint32_t>(width_), height = static_cast<uint32_t>(height_);
  lightPixels<kUnlights><<<tileGrid(width, height), kTileBlockThreads, 0, stream>>>(field(), kUnlights ? matter_.data() : unlit_.data(), from_->normals.data(),
                                                                                    segmentLightsFor(head_, camera), camera.eye,
                                                                                    kUnlights ? unlit_.data() : matter_.data());
  WARPSCOPE_CUDA_CHECK_LAUNCH();
}

SegmentField DeviceSegmentField::field() const { return fieldOf(pixels_, fieldDepths_.picture, width_, height_, first_, spans_, matter_, places_, tiles_); }

}  // namespace warpscope
