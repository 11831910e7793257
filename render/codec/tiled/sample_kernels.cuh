// Samples of a frame in device memory, and the values of its tiles: see tiled_samples.h for what these are.
// For one .cu file.
#pragma once

#include "render/codec/tiled/tile_samples.h"
#include "render/codec/tiled/value_kernels.cuh"
#include "render/core/placed_hash.h"
#include "render/march/sample_radius.h"

namespace warpscope {
namespace {

__host__ __device__ constexpr uint32_t planeOf(SampleNumbers plane) { return static_cast<uint32_t>(plane); }
__host__ __device__ constexpr uint32_t planeOf(SampleBytes plane) { return static_cast<uint32_t>(plane); }

}  // namespace

struct SampleView {
  PathGrid paths;
  SampleRule rule;
  float edge = 0.0f;
  bool isAsBefore = false;  ///< radii are predicted from those beside, not by the rule
  uint32_t count = 0;
  PackedSample* samples = nullptr;
  Rgba8* colors = nullptr;
  uint8_t* layers = nullptr;  ///< null where each sample is its ray's only one
  // In the order of streams.
  int32_t* origins = nullptr;
  uint32_t *places = nullptr, *streamColors = nullptr, *radii = nullptr;

  FrontJobs jobs() const {
    FrontJobs jobs;
    jobs.origins = origins;
    jobs.bits = fineBitsOf(paths.placement);
    jobs.add(FrontKind::place, planeOf(SampleNumbers::place), places);
    jobs.add(FrontKind::color, planeOf(SampleBytes::alpha), streamColors);
    if (isAsBefore) jobs.add(FrontKind::radius, planeOf(SampleNumbers::radius), radii);
    return jobs;
  }
  __device__ uint32_t likelyRadius(uint32_t depthCode, Rgba8 color) const {
    return radiusCodeFor(rule, edge, depthCode, static_cast<float>(color >> 24) / 255.0f, 0.0f);
  }
};

namespace {

/// A thread for each sample.
__global__ void countSamples(SampleView frame, SheetView view, unsigned long long* hash) {
  const uint32_t i = blockIdx.x * blockDim.x + threadIdx.x;
  if (i < frame.count) {
    const uint32_t layer = frame.layers != nullptr ? frame.layers[i] : 0;
    const bool isLast = frame.layers == nullptr || i + 1 == frame.count || frame.layers[i + 1] == 0;
    if (isLast) view.counts[size_t{rowOf(frame.samples[i])} * view.grid.width + columnOf(frame.samples[i])] = static_cast<uint8_t>(layer + 1);
  }
  addHash(i < frame.count ? placedHash(frame.samples[i], i) : 0, hash);
}

/// Values in the order of streams, and planes of what is not predicted from neighbours.
__global__ void __launch_bounds__(kCodedTileWidth) arrangeSamples(SampleView frame, SheetView view) {
  const Placement placement = frame.paths.placement;
  const float step = frame.paths.step, depthStep = frame.paths.depthStep;
  forValues(frame.paths, view, [&](const PixelPath& path, uint32_t, uint32_t i, uint32_t at) {
    const PackedSample sample = frame.samples[i];
    const Rgba8 color = frame.colors[i];
    const uint32_t code = depthCode(sample), radius = radiusCode(sample);
    const int32_t place = placement == Placement::depth ? static_cast<int32_t>(code) : placeOnPath(path, code, step, depthStep, placement == Placement::halfSteps);
    const auto put = [&](SampleNumbers plane, uint32_t number) { view.numbers[size_t{planeOf(plane)} * view.values + at] = number; };
    put(SampleNumbers::depth, zigzag(static_cast<int32_t>(code) - static_cast<int32_t>(depthCodeOnPath(path, place, step, depthStep, placement))));
    if (frame.isAsBefore)
      frame.radii[at] = radius;
    else
      put(SampleNumbers::radius, zigzag(static_cast<int32_t>(radius) - static_cast<int32_t>(frame.likelyRadius(code, color))));
    frame.origins[at] = path.origin;
    frame.places[at] = static_cast<uint32_t>(place);
    frame.streamColors[at] = color;
  });
}

/// Back.
__global__ void __launch_bounds__(kCodedTileWidth) finishSamples(SampleView frame, SheetView view, unsigned long long* hash) {
  if (!view.isFull() || (*view.flags & ~static_cast<uint32_t>(kWithoutRadius)) != 0) return;
  const TileRect rect = view.grid.at(blockIdx.x);
  uint64_t own = 0;
  bool lacksRadius = false;
  forValues(frame.paths, view, [&](const PixelPath& path, uint32_t layer, uint32_t i, uint32_t at) {
    const auto take = [&](SampleNumbers plane) { return view.numbers[size_t{planeOf(plane)} * view.values + at]; };
    const uint32_t likely = depthCodeOnPath(path, static_cast<int32_t>(frame.places[at]), frame.paths.step, frame.paths.depthStep, frame.paths.placement);
    const uint32_t code = (likely + static_cast<uint32_t>(unzigzag(take(SampleNumbers::depth)))) & kDepthCodeMax;
    const Rgba8 color = frame.streamColors[at];
    const uint32_t radius =
        frame.isAsBefore ? frame.radii[at] : (frame.likelyRadius(code, color) + static_cast<uint32_t>(unzigzag(take(SampleNumbers::radius)))) & kRadiusCodeMax;
    lacksRadius |= radius == 0;
    const PackedSample sample = packCodes(rect.x0 + threadIdx.x, rect.y0 + blockIdx.y, code, radius);
    frame.samples[i] = sample;
    frame.colors[i] = color;
    if (frame.layers != nullptr) frame.layers[i] = static_cast<uint8_t>(layer);
    own += placedHash(sample, i);
  });
  if (lacksRadius) atomicOr(view.flags, kWithoutRadius);
  addHash(own, hash);
}

}  // namespace
}  // namespace warpscope
