// Segments of a frame's rays in device memory, and the planes of its tiles: see tiled_segments.h for what these are.
// For one .cu file.
#pragma once

#include "render/codec/tiled/tile_segments.h"
#include "render/codec/tiled/value_kernels.cuh"
#include "render/march/frame_segments.h"

namespace warpscope {
namespace {

__host__ __device__ constexpr uint32_t planeOf(SegmentNumbers plane) { return static_cast<uint32_t>(plane); }
__host__ __device__ constexpr uint32_t planeOf(SegmentBytes plane) { return static_cast<uint32_t>(plane); }

/// A frame's segments in device memory, and what of them is between them and planes.
struct SegmentView {
  PathGrid paths;
  uint32_t pixels = 0, count = 0;
  uint8_t* rays = nullptr;
  SegmentDepths* depths = nullptr;
  Rgba8* colors = nullptr;
  NormalCode* normals = nullptr;  ///< null where there are none
  int32_t *begins = nullptr, *ends = nullptr;  ///< places
  uint32_t *beginRests = nullptr, *endRests = nullptr;
};

__global__ void countRays(SegmentView frame, SheetView view) {
  const uint32_t pixel = blockIdx.x * blockDim.x + threadIdx.x;
  if (pixel < frame.pixels) view.counts[pixel] = frame.rays[pixel] & 0x1f;
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

/// Where the first segment of a pixel is among the frame's: of the calling thread's pixel. Threads of a warp have pixels side by side in a tile's row.
__device__ uint32_t firstOfPixel(const SheetView& view, const TileRect& rect, uint32_t x, uint32_t y) {
  // A warp's part of the row: what lies left of it, then of the warp.
  uint32_t before = 0;
  const uint32_t begin = x / 32 * 32;
  for (uint32_t left = threadIdx.x % 32; left < min(begin, rect.width); left += 32) before += view.counts[view.pixel(rect, left, y)];
  before = __reduce_add_sync(kAllLanes, before);
  uint32_t own = x < rect.width ? view.counts[view.pixel(rect, x, y)] : 0;
  uint32_t sum = own;
  for (uint32_t offset = 1; offset < 32; offset *= 2) {
    const uint32_t other = __shfl_up_sync(kAllLanes, sum, offset);
    if (threadIdx.x % 32 >= offset) sum += other;
  }
  return view.rowBegin(rect, y) + before + sum - own;
}

/// Calls f(segment, column, row, path) for each segment of the calling thread's pixel. A block for each row of each tile, a thread for each column.
template <class F>
__device__ void forSegments(const PathGrid& paths, const SheetView& view, const F& f) {
  const TileRect rect = view.grid.at(blockIdx.x);
  const uint32_t x = threadIdx.x, y = blockIdx.y;
  if (y >= rect.height) return;
  const uint32_t first = firstOfPixel(view, rect, x, y);
  if (x >= rect.width) return;
  const uint32_t count = view.counts[view.pixel(rect, x, y)];
  if (count == 0) return;
  const PixelPath path = paths.path(rect.x0 + x, rect.y0 + y);
  for (uint32_t layer = 0; layer < count; ++layer) f(first + layer, path);
}

/// Places of borders, and what depth codes are beside them.
__global__ void __launch_bounds__(kTileWidth) lookAtSegments(SegmentView frame, SheetView view) {
  const Placement placement = frame.paths.placement;
  const float step = frame.paths.step, depthStep = frame.paths.depthStep;
  forSegments(frame.paths, view, [&](uint32_t i, const PixelPath& path) {
    const auto look = [&](uint32_t code, int32_t* places, uint32_t* rests) {
      const int32_t place = placement == Placement::depth ? static_cast<int32_t>(code) : borderOnPath(path, code, step, depthStep);
      places[i] = place;
      rests[i] = zigzag(static_cast<int32_t>(code - depthCodeOnPath(path, place, step, depthStep, placement)));
    };
    const SegmentDepths depths = frame.depths[i];
    look(depths.begin, frame.begins, frame.beginRests);
    look(depths.end, frame.ends, frame.endRests);
  });
}

/// What a segment's neighbours know of places: the beginning, or behind the front layer the gap to the end in front; the end.
__device__ int32_t beginOf(int32_t place, bool isFront, int32_t endInFront, int32_t origin, int bits) {
  return isFront ? fineOfPlace(place, origin, bits) : differenceOf(place, endInFront);
}
__device__ int32_t likelyBegin(const FrontNeighbors& from, bool isFront, int32_t endInFront, int32_t origin, int bits) {
  const int32_t likely = predicted(from.west.place, from.north.place, from.northWest.place);
  return isFront ? placeOfFine(likely, origin, bits) : sumOf(endInFront, likely);
}
__device__ int32_t likelyEnd(const FrontNeighbors& from, int32_t origin, int bits) {
  return placeOfFine(predicted(from.west.end, from.north.end, from.northWest.end), origin, bits);
}

/// A warp for each stream: planes of segments.
__global__ void __launch_bounds__(32) putSegments(SegmentView frame, SheetView view, const int32_t* origins) {
  const uint32_t stream = blockIdx.x, layer = stream % view.layers;
  if (view.sizeOf(stream) == 0) return;
  const TileRect rect = view.grid.at(stream / view.layers);
  RowCursor cursor = RowCursor::of(view, rect, stream);
  const int bits = fineBitsOf(frame.paths.placement);
  goThroughTile(
      rect, [&](uint32_t x, uint32_t y) { return cursor.goOn(view.counts[view.pixel(rect, x, y)], layer); },
      [&](uint32_t x, uint32_t y, const FrontNeighbors& from) {
        const uint32_t i = cursor.own + layer, at = cursor.at++;
        const int32_t origin = origins[view.pixel(rect, x, y)], front = layer > 0 ? frame.ends[i - 1] : 0;
        const int32_t begin = frame.begins[i], end = frame.ends[i];
        const auto put = [&](SegmentNumbers plane, uint32_t value) { view.numbers[size_t{planeOf(plane)} * view.values + at] = value; };
        put(SegmentNumbers::begin, zigzag(differenceOf(begin, likelyBegin(from, layer == 0, front, origin, bits))));
        put(SegmentNumbers::end, zigzag(differenceOf(end, likelyEnd(from, origin, bits))));
        put(SegmentNumbers::beginRest, frame.beginRests[i]);
        put(SegmentNumbers::endRest, frame.endRests[i]);
        FrontValues own{beginOf(begin, layer == 0, front, origin, bits), fineOfPlace(end, origin, bits), frame.colors[i], 0};
        putColor(view, planeOf(SegmentBytes::alpha), from, own.color, at);
        if (frame.normals != nullptr) {
          own.other = frame.normals[i];
          for (int part = 0; part < 2; ++part)
            view.bytes[size_t{planeOf(SegmentBytes::normalLow) + part} * view.values + at] =
                static_cast<uint8_t>(static_cast<int32_t>(own.other >> 8 * part & 255) - predictedChannel(from, &FrontValues::other, 8 * part));
        }
        return own;
      });
}

/// Back. A warp for each tile, whose layers follow one another: gaps are from ends in front.
__global__ void __launch_bounds__(32) takeSegmentsFrom(SegmentView frame, SheetView view, const int32_t* origins) {
  const uint32_t tile = blockIdx.x;
  if (!view.isFull() || *view.flags != 0) return;
  const TileRect rect = view.grid.at(tile);
  const int bits = fineBitsOf(frame.paths.placement);
  for (uint32_t layer = 0; layer < view.streams[tile]; ++layer) {
    if (view.sizeOf(tile * view.layers + layer) == 0) return;
    RowCursor cursor = RowCursor::of(view, rect, tile * view.layers + layer);
    goThroughTile(
        rect, [&](uint32_t x, uint32_t y) { return cursor.goOn(view.counts[view.pixel(rect, x, y)], layer); },
        [&](uint32_t x, uint32_t y, const FrontNeighbors& from) {
          const uint32_t i = cursor.own + layer, at = cursor.at++;
          const int32_t origin = origins[view.pixel(rect, x, y)], front = layer > 0 ? frame.ends[i - 1] : 0;
          const auto take = [&](SegmentNumbers plane) { return view.numbers[size_t{planeOf(plane)} * view.values + at]; };
          const int32_t begin = sumOf(likelyBegin(from, layer == 0, front, origin, bits), unzigzag(take(SegmentNumbers::begin)));
          const int32_t end = sumOf(likelyEnd(from, origin, bits), unzigzag(take(SegmentNumbers::end)));
          frame.begins[i] = begin;
          frame.ends[i] = end;
          frame.beginRests[i] = take(SegmentNumbers::beginRest);
          frame.endRests[i] = take(SegmentNumbers::endRest);
          FrontValues own{beginOf(begin, layer == 0, front, origin, bits), fineOfPlace(end, origin, bits), takeColor(view, planeOf(SegmentBytes::alpha), from, at), 0};
          frame.colors[i] = own.color;
          if (frame.normals != nullptr) {
            for (int part = 0; part < 2; ++part) {
              const int32_t difference = view.bytes[size_t{planeOf(SegmentBytes::normalLow) + part} * view.values + at];
              own.other |= static_cast<uint32_t>((predictedChannel(from, &FrontValues::other, 8 * part) + difference) & 255) << 8 * part;
            }
            frame.normals[i] = static_cast<NormalCode>(own.other);
          }
          return own;
        });
    __syncwarp();  // what the layer behind reads of ends
  }
}

/// Depth codes from places.
__global__ void __launch_bounds__(kTileWidth) finishSegments(SegmentView frame, SheetView view) {
  if (!view.isFull() || *view.flags != 0) return;
  forSegments(frame.paths, view, [&](uint32_t i, const PixelPath& path) {
    const auto code = [&](int32_t place, uint32_t rest) {
      const uint32_t likely = depthCodeOnPath(path, place, frame.paths.step, frame.paths.depthStep, frame.paths.placement);
      return (likely + static_cast<uint32_t>(unzigzag(rest))) & kDepthCodeMax;
    };
    frame.depths[i] = {code(frame.begins[i], frame.beginRests[i]), code(frame.ends[i], frame.endRests[i])};
  });
}

/// As TiledSegments: rays, depths, normals. A thread for each pixel or segment, whichever are more.
__global__ void hashSegments(SegmentView frame, unsigned long long* hash) {
  const uint32_t i = blockIdx.x * blockDim.x + threadIdx.x;
  uint64_t own = 0;
  if (i < frame.pixels) own += placedHash(frame.rays[i], i);
  if (i < frame.count) {
    own += placedHash(frame.depths[i].begin | uint64_t{frame.depths[i].end} << 32, uint64_t{frame.pixels} + i);
    if (frame.normals != nullptr) own += placedHash(frame.normals[i], uint64_t{frame.pixels} + frame.count + i);
  }
  addHash(own, hash);
}

}  // namespace
}  // namespace warpscope
