// Samples of a frame in device memory, and the planes of its tiles: see tiled_samples.h for what these are.
// For one .cu file.
#pragma once

#include "render/codec/tiled/tile_samples.h"
#include "render/codec/tiled/value_kernels.cuh"
#include "render/march/sample_radius.h"

namespace warpscope {
namespace {

__host__ __device__ constexpr uint32_t planeOf(SampleNumbers plane) { return static_cast<uint32_t>(plane); }
__host__ __device__ constexpr uint32_t planeOf(SampleBytes plane) { return static_cast<uint32_t>(plane); }

/// A frame's samples in device memory, and what of them is between them and planes.
struct SampleView {
  PathGrid paths;
  SampleRule rule;
  float edge = 0.0f;
  bool isAsBefore = false;  ///< radii are predicted from those beside
  uint32_t count = 0;
  PackedSample* samples = nullptr;
  Rgba8* colors = nullptr;
  uint8_t* layers = nullptr;  ///< null where each sample is its ray's only one
  int32_t* fines = nullptr;   ///< of each sample
  int32_t* places = nullptr;
  uint32_t* depths = nullptr;  ///< differences of depth codes from those of places
  uint32_t* radii = nullptr;   ///< of radius codes from those that are likely; codes themselves where radii are as those beside
};

/// What is known of each sample alone. A thread for each.
__global__ void lookAtSamples(SampleView frame, SheetView view) {
  const uint32_t i = blockIdx.x * blockDim.x + threadIdx.x;
  if (i >= frame.count) return;
  const PackedSample sample = frame.samples[i];
  const uint32_t column = columnOf(sample), row = rowOf(sample), code = depthCode(sample);
  const Placement placement = frame.paths.placement;
  const PixelPath path = frame.paths.path(column, row);
  const float step = frame.paths.step, depthStep = frame.paths.depthStep;
  const int32_t place = placement == Placement::depth ? static_cast<int32_t>(code) : placeOnPath(path, code, step, depthStep, placement == Placement::halfSteps);
  frame.places[i] = place;
  frame.fines[i] = fineOfPlace(place, path.origin, fineBitsOf(placement));
  frame.depths[i] = zigzag(static_cast<int32_t>(code) - static_cast<int32_t>(depthCodeOnPath(path, place, step, depthStep, placement)));
  const uint32_t radius = radiusCode(sample);
  if (frame.isAsBefore) {
    frame.radii[i] = radius;
  } else {
    const float opacity = static_cast<float>(frame.colors[i] >> 24) / 255.0f;
    frame.radii[i] = zigzag(static_cast<int32_t>(radius) - static_cast<int32_t>(radiusCodeFor(frame.rule, frame.edge, code, opacity, 0.0f)));
  }
  const uint32_t layer = frame.layers != nullptr ? frame.layers[i] : 0;
  const bool isLast = frame.layers == nullptr || i + 1 == frame.count || frame.layers[i + 1] == 0;
  if (isLast) view.counts[size_t{row} * view.grid.width + column] = static_cast<uint8_t>(layer + 1);
}

/// A warp for each stream: planes of samples.
__global__ void __launch_bounds__(32) putSamples(SampleView frame, SheetView view) {
  const uint32_t stream = blockIdx.x, layer = stream % view.layers;
  if (view.sizeOf(stream) == 0) return;
  const TileRect rect = view.grid.at(stream / view.layers);
  RowCursor cursor = RowCursor::of(view, rect, stream);
  const int bits = fineBitsOf(frame.paths.placement);
  goThroughTile(
      rect, [&](uint32_t x, uint32_t y) { return cursor.goOn(view.counts[view.pixel(rect, x, y)], layer); },
      [&](uint32_t, uint32_t, const FrontNeighbors& from) {
        const uint32_t i = cursor.own + layer, at = cursor.at++;
        FrontValues own;
        own.place = frame.fines[i];
        own.color = frame.colors[i];
        own.other = frame.radii[i];
        const int32_t place = frame.places[i], origin = differenceOf(own.place, static_cast<int32_t>(static_cast<uint32_t>(place) << bits));
        const int32_t likely = placeOfFine(predicted(from.west.place, from.north.place, from.northWest.place), origin, bits);
        const auto put = [&](SampleNumbers plane, uint32_t value) { view.numbers[size_t{planeOf(plane)} * view.values + at] = value; };
        put(SampleNumbers::place, zigzag(differenceOf(place, likely)));
        put(SampleNumbers::depth, frame.depths[i]);
        const auto radius = [](const FrontValues& of) { return static_cast<int32_t>(of.other); };
        put(SampleNumbers::radius,
            frame.isAsBefore ? zigzag(radius(own) - predicted(radius(from.west), radius(from.north), radius(from.northWest))) : own.other);
        putColor(view, planeOf(SampleBytes::alpha), from, own.color, at);
        return own;
      });
}

/// Back: places, colours and, where radii are as those beside, radius codes; else differences of radii. Samples get their pixels.
__global__ void __launch_bounds__(32) takeSamplesFrom(SampleView frame, SheetView view, const int32_t* origins) {
  const uint32_t stream = blockIdx.x, layer = stream % view.layers;
  if (!view.isFull() || *view.flags != 0 || view.sizeOf(stream) == 0) return;
  const TileRect rect = view.grid.at(stream / view.layers);
  RowCursor cursor = RowCursor::of(view, rect, stream);
  const int bits = fineBitsOf(frame.paths.placement);
  goThroughTile(
      rect, [&](uint32_t x, uint32_t y) { return cursor.goOn(view.counts[view.pixel(rect, x, y)], layer); },
      [&](uint32_t x, uint32_t y, const FrontNeighbors& from) {
        const uint32_t i = cursor.own + layer, at = cursor.at++;
        const int32_t origin = origins[view.pixel(rect, x, y)];
        const auto take = [&](SampleNumbers plane) { return view.numbers[size_t{planeOf(plane)} * view.values + at]; };
        const int32_t likely = placeOfFine(predicted(from.west.place, from.north.place, from.northWest.place), origin, bits);
        const int32_t place = sumOf(likely, unzigzag(take(SampleNumbers::place)));
        FrontValues own;
        own.place = fineOfPlace(place, origin, bits);
        own.color = takeColor(view, planeOf(SampleBytes::alpha), from, at);
        own.other = take(SampleNumbers::radius);
        if (frame.isAsBefore) {
          const auto radius = [](const FrontValues& of) { return static_cast<int32_t>(of.other); };
          const int32_t likelyRadius = predicted(radius(from.west), radius(from.north), radius(from.northWest));
          own.other = (static_cast<uint32_t>(likelyRadius) + static_cast<uint32_t>(unzigzag(own.other))) & kRadiusCodeMax;
        }
        frame.places[i] = place;
        frame.depths[i] = take(SampleNumbers::depth);
        frame.radii[i] = own.other;
        frame.colors[i] = own.color;
        frame.samples[i] = packCodes(rect.x0 + x, rect.y0 + y, 0, 0);
        if (frame.layers != nullptr) frame.layers[i] = static_cast<uint8_t>(layer);
        return own;
      });
}

/// Depth and radius codes of samples that have their pixels. A thread for each.
__global__ void finishSamples(SampleView frame, SheetView view, unsigned long long* hash) {
  if (!view.isFull() || *view.flags != 0) return;
  const uint32_t i = blockIdx.x * blockDim.x + threadIdx.x;
  uint64_t own = 0;
  if (i < frame.count) {
    const uint32_t column = columnOf(frame.samples[i]), row = rowOf(frame.samples[i]);
    const PixelPath path = frame.paths.path(column, row);
    const uint32_t likely = depthCodeOnPath(path, frame.places[i], frame.paths.step, frame.paths.depthStep, frame.paths.placement);
    const uint32_t code = (likely + static_cast<uint32_t>(unzigzag(frame.depths[i]))) & kDepthCodeMax;
    uint32_t radius = frame.radii[i];
    if (!frame.isAsBefore) {
      const float opacity = static_cast<float>(frame.colors[i] >> 24) / 255.0f;
      radius = (radiusCodeFor(frame.rule, frame.edge, code, opacity, 0.0f) + static_cast<uint32_t>(unzigzag(radius))) & kRadiusCodeMax;
    }
    const PackedSample sample = packCodes(column, row, code, radius);
    frame.samples[i] = sample;
    own = placedHash(sample, i);
  }
  addHash(own, hash);
}

__global__ void hashSamples(SampleView frame, unsigned long long* hash) {
  const uint32_t i = blockIdx.x * blockDim.x + threadIdx.x;
  addHash(i < frame.count ? placedHash(frame.samples[i], i) : 0, hash);
}

}  // namespace
}  // namespace warpscope
