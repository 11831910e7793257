// Segments of a frame's rays in device memory, and the values of its tiles: see tiled_segments.h for what these are.
// For one .cu file.
#pragma once

#include "render/codec/tiled/tile_segments.h"
#include "render/codec/tiled/value_kernels.cuh"
#include "render/core/placed_hash.h"
#include "render/march/frame_segments.h"

namespace warpscope {
namespace {

__host__ __device__ constexpr uint32_t planeOf(SegmentNumbers plane) { return static_cast<uint32_t>(plane); }
__host__ __device__ constexpr uint32_t planeOf(SegmentBytes plane) { return static_cast<uint32_t>(plane); }

}  // namespace

struct SegmentView {
  PathGrid paths;
  uint32_t pixels = 0, count = 0;
  uint8_t* rays = nullptr;
  SegmentDepths* depths = nullptr;
  Rgba8* colors = nullptr;
  NormalCode* normals = nullptr;  ///< null where there are none
  // In the order of streams.
  int32_t* origins = nullptr;
  uint32_t* begins = nullptr;  ///< places; behind the front layer gaps to the end in front
  uint32_t *ends = nullptr, *streamColors = nullptr, *streamNormals = nullptr;

  FrontJobs jobs() const {
    FrontJobs jobs;
    jobs.origins = origins;
    jobs.bits = fineBitsOf(paths.placement);
    jobs.add(FrontKind::gap, planeOf(SegmentNumbers::begin), begins);
    jobs.add(FrontKind::place, planeOf(SegmentNumbers::end), ends);
    jobs.add(FrontKind::color, planeOf(SegmentBytes::alpha), streamColors);
    if (normals != nullptr) jobs.add(FrontKind::channels, planeOf(SegmentBytes::normalLow), streamNormals);
    return jobs;
  }
};

namespace {

__global__ void countRays(SegmentView frame, SheetView view) {
  const uint32_t pixel = blockIdx.x * blockDim.x + threadIdx.x;
  if (pixel < frame.pixels) view.counts[pixel] = static_cast<uint8_t>(RaySegmentCount::ofBits(frame.rays[pixel]).count());
}

/// A block for each tile: rays' bytes, changed by those to the left.
__global__ void putRays(SegmentView frame, SheetView view) {
  const uint32_t tile = blockIdx.x;
  const TileRect rect = view.grid.at(tile);
  uint8_t* const shape = view.shape(0, tile);
  bool isAny = false;
  for (uint32_t i = threadIdx.x; i < rect.pixels(); i += blockDim.x) {
    const uint32_t x = i % rect.width, y = i / rect.width;
    const size_t pixel = view.pixel(rect, x, y);
    const uint32_t before = x > 0 ? frame.rays[pixel - 1] : y > 0 ? frame.rays[pixel - view.grid.width] : 0;
    shape[i] = static_cast<uint8_t>(frame.rays[pixel] ^ before);
    isAny |= shape[i] != 0;
  }
  isAny = __syncthreads_or(isAny) != 0;
  if (threadIdx.x != 0) return;
  uint32_t layers = 0;
  while (layers < view.layers && view.sizeOf(tile * view.layers + layers) > 0) ++layers;
  view.streams[tile] = static_cast<uint8_t>(isAny ? max(layers, 1u) : 0);
}

/// Values in the order of streams, and what depth codes are beside places.
__global__ void __launch_bounds__(kCodedTileWidth) arrangeSegments(SegmentView frame, SheetView view) {
  const Placement placement = frame.paths.placement;
  const float step = frame.paths.step, depthStep = frame.paths.depthStep;
  uint32_t front = 0;  // where the segment in front ends
  forValues(frame.paths, view, [&](const PixelPath& path, uint32_t layer, uint32_t i, uint32_t at) {
    const auto placeOf = [&](uint32_t code, SegmentNumbers rests) {
      const int32_t place = placement == Placement::depth ? static_cast<int32_t>(code) : borderOnPath(path, code, step, depthStep);
      view.numbers[size_t{planeOf(rests)} * view.values + at] = zigzag(static_cast<int32_t>(code - depthCodeOnPath(path, place, step, depthStep, placement)));
      return static_cast<uint32_t>(place);
    };
    const SegmentDepths depths = frame.depths[i];
    const uint32_t begin = placeOf(depths.begin, SegmentNumbers::beginRest), end = placeOf(depths.end, SegmentNumbers::endRest);
    frame.begins[at] = layer > 0 ? begin - front : begin;
    frame.ends[at] = front = end;
    frame.streamColors[at] = frame.colors[i];
    if (frame.normals != nullptr) frame.streamNormals[at] = frame.normals[i];
    frame.origins[at] = path.origin;
  });
}

/// Back. What it finds out itself other blocks do not end for: all threads of a block have to see the same.
__global__ void __launch_bounds__(kCodedTileWidth) finishSegments(SegmentView frame, SheetView view) {
  if (!view.isFull() || (*view.flags & ~static_cast<uint32_t>(kDisordered)) != 0) return;
  uint32_t front = 0, last = 0;
  bool isOrdered = true;
  forValues(frame.paths, view, [&](const PixelPath& path, uint32_t layer, uint32_t i, uint32_t at) {
    const auto codeOf = [&](uint32_t place, SegmentNumbers rests) {
      const uint32_t likely = depthCodeOnPath(path, static_cast<int32_t>(place), frame.paths.step, frame.paths.depthStep, frame.paths.placement);
      return (likely + static_cast<uint32_t>(unzigzag(view.numbers[size_t{planeOf(rests)} * view.values + at]))) & kDepthCodeMax;
    };
    const uint32_t begin = layer > 0 ? front + frame.begins[at] : frame.begins[at];
    front = frame.ends[at];
    const SegmentDepths depths{codeOf(begin, SegmentNumbers::beginRest), codeOf(front, SegmentNumbers::endRest)};
    isOrdered &= last <= depths.begin && depths.begin <= depths.end;
    last = depths.end;
    frame.depths[i] = depths;
    frame.colors[i] = frame.streamColors[at];
    if (frame.normals != nullptr) frame.normals[i] = static_cast<NormalCode>(frame.streamNormals[at]);
  });
  if (!isOrdered) atomicOr(view.flags, kDisordered);
}

/// As TiledSegments: rays, depths, normals.
__global__ void hashSegments(SegmentView frame, unsigned long long* hash) {
  uint64_t own = 0;
  for (size_t i = size_t{blockIdx.x} * blockDim.x + threadIdx.x; i < max(frame.pixels, frame.count); i += size_t{gridDim.x} * blockDim.x) {
    if (i < frame.pixels) own += placedHash(frame.rays[i], i);
    if (i < frame.count) {
      own += placedHash(frame.depths[i].begin | uint64_t{frame.depths[i].end} << 32, frame.pixels + i);
      if (frame.normals != nullptr) own += placedHash(frame.normals[i], uint64_t{frame.pixels} + frame.count + i);
    }
  }
  addHash(own, hash);
}

}  // namespace
}  // namespace warpscope
