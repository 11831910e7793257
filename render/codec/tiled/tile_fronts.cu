// One word of a value at a time: warps that go through the same tile for others do not wait for one another.
// See tile_fronts.h.
#include "render/codec/tiled/tile_fronts.h"

#include "render/codec/band_layout.h"
#include "render/codec/tokens.h"
#include "render/cuda/warp_reduce.cuh"
#include "render/march/pixel_places.h"

namespace warpscope {
namespace {

static_assert(kCodedTileHeight == 32, "a row is a thread of a warp");
constexpr unsigned kThreads = 128;
constexpr uint32_t kMaskWords = kCodedTileWidth / 32;

struct FrontNeighbors {
  uint32_t west, north, northWest;
};

__device__ int32_t likelyNumber(const FrontNeighbors& from) {
  return predicted(static_cast<int32_t>(from.west), static_cast<int32_t>(from.north), static_cast<int32_t>(from.northWest));
}
__device__ int32_t likelyChannel(const FrontNeighbors& from, int shift) {
  const auto channel = [&](uint32_t of) { return static_cast<int32_t>(of >> shift & 255); };
  return predicted(channel(from.west), channel(from.north), channel(from.northWest));
}

// Of each kind: what neighbours know of a value, its difference and back.

/// Numbers, of rays whose places begin at origins. To be written they come in fine units: what is likely in places is as far from a place as it is in those.
struct NumberRule {
  int bits;
  uint32_t mask;  // of values

  __device__ uint32_t known(uint32_t value, int32_t origin) const { return static_cast<uint32_t>(fineOfPlace(static_cast<int32_t>(value), origin, bits)); }
  __device__ uint32_t likely(const FrontNeighbors& from, int32_t origin) const { return static_cast<uint32_t>(placeOfFine(likelyNumber(from), origin, bits)); }
  __device__ uint32_t difference(uint32_t fine, const FrontNeighbors& from) const { return zigzag(-placeOfFine(likelyNumber(from), static_cast<int32_t>(fine), bits)); }
  __device__ uint32_t value(uint32_t difference, const FrontNeighbors& from, int32_t origin) const {
    return (likely(from, origin) + static_cast<uint32_t>(unzigzag(difference))) & mask;
  }
};

/// Differences are bytes from the lowest: opacity, green, red, blue.
struct ColorRule {
  __device__ uint32_t known(uint32_t value, int32_t) const { return value; }
  __device__ uint32_t difference(uint32_t value, const FrontNeighbors& from) const {
    const auto of = [&](int shift) { return static_cast<int32_t>(value >> shift & 255) - likelyChannel(from, shift); };
    const int32_t green = of(8);
    const auto byte = [](int32_t difference, int shift) { return static_cast<uint32_t>(difference & 255) << shift; };
    return byte(of(24), 0) | byte(green, 8) | byte(of(0) - green, 16) | byte(of(16) - green, 24);
  }
  __device__ uint32_t value(uint32_t difference, const FrontNeighbors& from, int32_t) const {
    const auto byte = [&](int shift) { return static_cast<int32_t>(difference >> shift & 255); };
    const auto channel = [&](int shift, int32_t own) { return static_cast<uint32_t>((likelyChannel(from, shift) + own) & 255) << shift; };
    const int32_t green = byte(8);
    return channel(24, byte(0)) | channel(8, green) | channel(0, byte(16) + green) | channel(16, byte(24) + green);
  }
};

struct ChannelRule {
  __device__ uint32_t known(uint32_t value, int32_t) const { return value; }
  __device__ uint32_t difference(uint32_t value, const FrontNeighbors& from) const {
    const auto of = [&](int shift) { return static_cast<uint32_t>((static_cast<int32_t>(value >> shift & 255) - likelyChannel(from, shift)) & 255) << shift; };
    return of(0) | of(8);
  }
  __device__ uint32_t value(uint32_t difference, const FrontNeighbors& from, int32_t) const {
    const auto of = [&](int shift) { return static_cast<uint32_t>((static_cast<int32_t>(difference >> shift & 255) + likelyChannel(from, shift)) & 255) << shift; };
    return of(0) | of(8);
  }
};

/// Makes differences of values (numbers in fine units), or values of differences, in place. `masks`: what the layer covers, kMaskWords a row; `first`: of the calling thread's row
/// among the words. `origins`: of values that are read.
template <bool kReads, class Rule>
__device__ void goThroughTile(const TileRect& rect, const uint32_t* masks, uint32_t first, uint32_t* words, const int32_t* origins, const Rule& rule) {
  const uint32_t row = threadIdx.x % 32;
  const uint32_t* const own = masks + row * kMaskWords;
  uint32_t west = 0, seen = 0;                      // what is known of the column before; what a pixel without neighbours is predicted from
  uint32_t north = 0, northWest = 0, northEast = 0;  // of the row above
  uint32_t at = first;
  bool isWest = false, isNorth = false, isNorthWest = false, hasSeen = false;
  const int steps = static_cast<int>(rect.width + 2 * (rect.height - 1));
  for (int step = 0; step < steps; ++step) {
    const int column = step - 2 * static_cast<int>(row);
    northWest = north;
    north = northEast;
    northEast = __shfl_up_sync(kAllLanes, west, 1);
    const uint32_t seenAbove = __shfl_up_sync(kAllLanes, seen, 1);
    if (column < 0 || column >= static_cast<int>(rect.width) || row >= rect.height) continue;
    const uint32_t bit = 1u << column % 32;
    isNorthWest = isNorth;
    isNorth = row > 0 && (own[column / 32 - static_cast<int>(kMaskWords)] & bit) != 0;
    if (!hasSeen) seen = row > 0 ? seenAbove : 0;
    const bool isCovered = (own[column / 32] & bit) != 0;
    if (isCovered) {
      FrontNeighbors from;
      from.west = isWest ? west : isNorth ? north : seen;
      from.north = isNorth ? north : from.west;
      from.northWest = isNorthWest ? northWest : from.north;
      const uint32_t word = words[at];
      if constexpr (kReads) {
        const int32_t origin = origins != nullptr ? origins[at] : 0;
        const uint32_t value = rule.value(word, from, origin);
        words[at] = value;
        west = seen = rule.known(value, origin);
      } else {
        words[at] = rule.difference(word, from);
        west = seen = word;
      }
      hasSeen = true;
      ++at;
    }
    isWest = isCovered;
  }
}

/// A block for each stream and job; the words of the stream, then origins of what is read, are in shared memory.
template <bool kReads>
__global__ void __launch_bounds__(kThreads) goThroughTiles(SheetView view, FrontJobs jobs) {
  extern __shared__ uint32_t words[];
  __shared__ uint32_t masks[kCodedTileHeight * kMaskWords];
  const uint32_t stream = blockIdx.x, tile = stream / view.layers, layer = stream % view.layers, begin = view.begins[stream], size = view.begins[stream + 1] - begin;
  if (size == 0) return;
  if (kReads && (!view.isFull() || *view.flags != 0)) return;
  const FrontJob job = jobs.jobs[blockIdx.y];
  const bool isNumber = job.kind == FrontKind::place || job.kind == FrontKind::gap || job.kind == FrontKind::radius;
  const bool hasOrigins = job.kind == FrontKind::place || (job.kind == FrontKind::gap && layer == 0);
  const int bits = hasOrigins ? jobs.bits : 0;
  const uint32_t planes = job.kind == FrontKind::color ? 4 : job.kind == FrontKind::channels ? 2 : 1;
  const TileRect rect = view.grid.at(tile);
  auto* const origins = reinterpret_cast<int32_t*>(words + size);
  const auto byteOf = [&](uint32_t plane, uint32_t i) -> uint8_t& { return view.bytes[size_t{job.plane + plane} * view.values + begin + i]; };

  for (uint32_t row = threadIdx.x / 32; row < rect.height; row += kThreads / 32)
    for (uint32_t word = 0; word < kMaskWords; ++word) {
      const uint32_t x = word * 32 + threadIdx.x % 32;
      const uint32_t mask = __ballot_sync(kAllLanes, x < rect.width && view.counts[view.pixel(rect, x, row)] > layer);
      if (threadIdx.x % 32 == 0) masks[row * kMaskWords + word] = mask;
    }
  for (uint32_t i = threadIdx.x; i < size; i += kThreads) {
    uint32_t word = 0;
    if (!kReads)
      word = hasOrigins ? static_cast<uint32_t>(fineOfPlace(static_cast<int32_t>(job.values[begin + i]), jobs.origins[begin + i], bits)) : job.values[begin + i];
    else if (isNumber)
      word = view.numbers[size_t{job.plane} * view.values + begin + i];
    else
      for (uint32_t plane = 0; plane < planes; ++plane) word |= static_cast<uint32_t>(byteOf(plane, i)) << 8 * plane;
    words[i] = word;
    if (kReads && hasOrigins) origins[i] = jobs.origins[begin + i];
  }
  __syncthreads();
  if (threadIdx.x < 32) {
    const uint32_t first = threadIdx.x < rect.height ? view.rowRanks[stream * kCodedTileHeight + threadIdx.x] : 0;
    if (isNumber)
      goThroughTile<kReads>(rect, masks, first, words, hasOrigins ? origins : nullptr, NumberRule{bits, job.kind == FrontKind::radius ? kRadiusCodeMax : ~0u});
    else if (job.kind == FrontKind::color)
      goThroughTile<kReads>(rect, masks, first, words, nullptr, ColorRule{});
    else
      goThroughTile<kReads>(rect, masks, first, words, nullptr, ChannelRule{});
  }
  __syncthreads();
  for (uint32_t i = threadIdx.x; i < size; i += kThreads) {
    const uint32_t word = words[i];
    if (kReads)
      job.values[begin + i] = word;
    else if (isNumber)
      view.numbers[size_t{job.plane} * view.values + begin + i] = word;
    else
      for (uint32_t plane = 0; plane < planes; ++plane) byteOf(plane, i) = static_cast<uint8_t>(word >> 8 * plane);
  }
}

template <bool kReads>
void run(const SheetView& view, const FrontJobs& jobs, cudaStream_t stream) {
  constexpr unsigned kBytes = (kReads ? 2 : 1) * static_cast<unsigned>(kCodedTilePixels * sizeof(uint32_t));  // the less, the more tiles at once
  static_assert(kBytes <= 48 * 1024, "what a kernel has without asking for more");
  goThroughTiles<kReads><<<dim3(view.tiles() * view.layers, jobs.count), kThreads, kBytes, stream>>>(view, jobs);
  WARPSCOPE_CUDA_CHECK_LAUNCH();
}

}  // namespace

void putFronts(const SheetView& view, const FrontJobs& jobs, cudaStream_t stream) { run<false>(view, jobs, stream); }
void takeFronts(const SheetView& view, const FrontJobs& jobs, cudaStream_t stream) { run<true>(view, jobs, stream); }

}  // namespace warpscope
