// Writing, all values of a tile at once. Reading, one word of a value at a time: warps that go through the same tile for others do not wait for one another.
// See tile_fronts.h.
#include "render/codec/tiled/tile_fronts.h"

#include "render/codec/band_layout.h"
#include "render/codec/tiled/symbol_counts.cuh"
#include "render/codec/tokens.h"
#include "render/cuda/warp_reduce.cuh"
#include "render/march/pixel_places.h"

namespace warpscope {
namespace {

static_assert(kCodedTileHeight == 32, "a row is a thread of a warp");
constexpr unsigned kFrontThreads = 128;

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

/// Which pixels of a tile have something in one layer. In shared memory.
struct LayerMasks {
  uint64_t rows[kCodedTileHeight];
  uint32_t firsts[kCodedTileHeight];  ///< how many are in rows above

  /// By all threads of a block.
  __device__ void fill(const SheetView& view, const TileRect& rect, uint32_t stream, uint32_t layer) {
    static_assert(kCodedTileWidth == 64, "a row is a word");
    const uint32_t lane = threadIdx.x % 32;
    for (uint32_t y = threadIdx.x / 32; y < kCodedTileHeight; y += blockDim.x / 32) {
      const auto covered = [&](uint32_t x) { return __ballot_sync(kAllLanes, x < rect.width && y < rect.height && view.counts[view.pixel(rect, x, y)] > layer); };
      const uint64_t left = covered(lane), right = covered(32 + lane);
      if (lane > 0) continue;
      rows[y] = left | right << 32;
      firsts[y] = view.rowRanks[stream * kCodedTileHeight + y];
    }
  }
  __device__ bool has(uint32_t x, uint32_t y) const { return (rows[y] >> x & 1) != 0; }
  /// How many are before the pixel.
  __device__ uint32_t rank(uint32_t x, uint32_t y) const { return firsts[y] + countBelow(x, y); }
  __device__ uint32_t countBelow(uint32_t x, uint32_t y) const { return static_cast<uint32_t>(__popcll(x < 64 ? rows[y] & ((uint64_t{1} << x) - 1) : rows[y])); }
};

constexpr uint32_t kNoFront = ~0u;

/// Values that one is predicted from, by their places in the stream.
struct FrontPlaces {
  uint32_t west = kNoFront, north = kNoFront, northWest = kNoFront;
};

/// Of value `i`, at a pixel of the tile: as tile_layer.h. kNoFront: there is none in front.
__device__ FrontPlaces frontPlaces(const LayerMasks& masks, uint32_t i, uint32_t x, uint32_t y) {
  FrontPlaces places;
  if (x > 0 && masks.has(x - 1, y)) places.west = i - 1;
  if (y > 0) {
    const uint32_t above = masks.rank(x, y - 1);
    if (masks.has(x, y - 1)) places.north = above;
    if (x > 0 && masks.has(x - 1, y - 1)) places.northWest = above - 1;
  }
  if (places.west == kNoFront) places.west = places.north;
  if (places.west == kNoFront) {
    if (i > masks.firsts[y]) {
      places.west = i - 1;
    } else {
      for (uint32_t up = 1; up <= y && places.west == kNoFront; ++up)
        if (const uint32_t before = masks.countBelow(x + up + 1, y - up); before > 0) places.west = masks.firsts[y - up] + before - 1;
    }
  }
  if (places.north == kNoFront) places.north = places.west;
  if (places.northWest == kNoFront) places.northWest = places.north;
  return places;
}

constexpr unsigned kPuttingThreads = 256;
constexpr uint32_t kMostPlanes = 8;  // of all jobs

/// A block for each stream: differences of all jobs' values, as planes, and how often which symbols occur. What neighbours are is known before any of them. Words of all jobs are in
/// shared memory.
__global__ void __launch_bounds__(kPuttingThreads) putDifferences(const __grid_constant__ SheetView view, const __grid_constant__ FrontJobs jobs) {
  extern __shared__ uint32_t words[];
  __shared__ uint16_t pixels[kCodedTilePixels];  // of each value
  __shared__ uint32_t counts[kMostPlanes][kAnsSymbols];
  __shared__ LayerMasks masks;
  const uint32_t stream = blockIdx.x, tile = stream / view.layers, layer = stream % view.layers, begin = view.begins[stream], size = view.begins[stream + 1] - begin;
  if (size == 0) return;
  masks.fill(view, view.grid.at(tile), stream, layer);
  for (uint32_t number = 0; number < jobs.count; ++number) {
    const FrontJob& job = jobs.jobs[number];
    const bool hasOrigins = job.hasOrigins(layer);
    for (uint32_t i = threadIdx.x; i < size; i += kPuttingThreads) {
      const uint32_t value = job.values[begin + i];
      words[number * kCodedTilePixels + i] = hasOrigins ? static_cast<uint32_t>(fineOfPlace(static_cast<int32_t>(value), jobs.origins[begin + i], jobs.bits)) : value;
    }
  }
  for (uint32_t i = threadIdx.x; i < kMostPlanes * kAnsSymbols; i += kPuttingThreads) counts[i / kAnsSymbols][i % kAnsSymbols] = 0;
  __syncthreads();
  for (uint32_t place = threadIdx.x; place < kCodedTilePixels; place += kPuttingThreads) {
    const uint32_t x = place % kCodedTileWidth, y = place / kCodedTileWidth;
    if (masks.has(x, y)) pixels[masks.rank(x, y)] = static_cast<uint16_t>(place);
  }
  __syncthreads();
  for (uint32_t first = 0; first < size; first += kPuttingThreads) {
    const uint32_t i = first + threadIdx.x;
    const bool isThere = i < size;
    FrontPlaces places;
    if (isThere) places = frontPlaces(masks, i, pixels[i] % kCodedTileWidth, pixels[i] / kCodedTileWidth);
    uint32_t plane = 0;  // among those of all jobs
    for (uint32_t number = 0; number < jobs.count; ++number) {
      const FrontJob& job = jobs.jobs[number];
      const uint32_t* const own = words + number * kCodedTilePixels;
      const auto known = [&](uint32_t place) { return place == kNoFront ? 0u : own[place]; };
      const auto difference = [&](const auto& rule) { return isThere ? rule.difference(own[i], {known(places.west), known(places.north), known(places.northWest)}) : 0; };
      if (job.isNumber()) {
        const uint32_t word = difference(NumberRule{job.hasOrigins(layer) ? jobs.bits : 0, ~0u});
        if (isThere) view.numbers[size_t{job.plane} * view.values + begin + i] = word;
        countSymbol(counts[plane++], isThere ? tokenOf(word) : kAnsSymbols);
        continue;
      }
      const uint32_t word = job.kind == FrontKind::color ? difference(ColorRule{}) : difference(ChannelRule{});
      for (uint32_t k = 0; k < job.planes(); ++k) {
        const uint32_t byte = word >> 8 * k & 255;
        if (isThere) view.bytes[size_t{job.plane + k} * view.values + begin + i] = static_cast<uint8_t>(byte);
        countSymbol(counts[plane++], isThere ? byte : kAnsSymbols);
      }
    }
  }
  __syncthreads();
  uint32_t plane = 0;
  for (uint32_t number = 0; number < jobs.count; ++number) {
    const FrontJob& job = jobs.jobs[number];
    uint32_t* const models = view.histograms + view.modelOf(layer, job.isNumber() ? job.plane : view.form.numbers + job.plane) * kAnsSymbols;
    for (uint32_t i = threadIdx.x; i < job.planes() * kAnsSymbols; i += kPuttingThreads)
      if (const uint32_t count = counts[plane + i / kAnsSymbols][i % kAnsSymbols]; count > 0) atomicAdd(&models[i], count);
    plane += job.planes();
  }
}

/// Makes values of differences, in place. `masks`: what the layer covers. `origins`: of places.
template <class Rule>
__device__ void goThroughTile(const TileRect& rect, const LayerMasks& masks, uint32_t* words, const int32_t* origins, const Rule& rule) {
  const uint32_t row = threadIdx.x % 32;
  const uint64_t own = masks.rows[row], above = row > 0 ? masks.rows[row - 1] : 0;
  uint32_t west = 0, seen = 0;                      // what is known of the column before; what a pixel without neighbours is predicted from
  uint32_t north = 0, northWest = 0, northEast = 0;  // of the row above
  uint32_t at = masks.firsts[row];
  bool isWest = false, isNorth = false, isNorthWest = false, hasSeen = false;
  const int steps = static_cast<int>(rect.width + 2 * (rect.height - 1));
  for (int step = 0; step < steps; ++step) {
    const int column = step - 2 * static_cast<int>(row);
    northWest = north;
    north = northEast;
    northEast = __shfl_up_sync(kAllLanes, west, 1);
    const uint32_t seenAbove = __shfl_up_sync(kAllLanes, seen, 1);
    if (column < 0 || column >= static_cast<int>(rect.width) || row >= rect.height) continue;
    isNorthWest = isNorth;
    isNorth = (above >> column & 1) != 0;
    if (!hasSeen) seen = row > 0 ? seenAbove : 0;
    const bool isCovered = (own >> column & 1) != 0;
    if (isCovered) {
      FrontNeighbors from;
      from.west = isWest ? west : isNorth ? north : seen;
      from.north = isNorth ? north : from.west;
      from.northWest = isNorthWest ? northWest : from.north;
      const int32_t origin = origins != nullptr ? origins[at] : 0;
      const uint32_t value = rule.value(words[at], from, origin);
      words[at] = value;
      west = seen = rule.known(value, origin);
      hasSeen = true;
      ++at;
    }
    isWest = isCovered;
  }
}

/// A block for each stream and job; the words of the stream, then origins, are in shared memory.
__global__ void __launch_bounds__(kFrontThreads) takeDifferences(const __grid_constant__ SheetView view, const __grid_constant__ FrontJobs jobs) {
  extern __shared__ uint32_t words[];
  __shared__ LayerMasks masks;
  const uint32_t stream = blockIdx.x, tile = stream / view.layers, layer = stream % view.layers, begin = view.begins[stream], size = view.begins[stream + 1] - begin;
  if (size == 0 || !view.isFull() || *view.flags != 0) return;
  const FrontJob job = jobs.jobs[blockIdx.y];
  const bool hasOrigins = job.hasOrigins(layer);
  const int bits = hasOrigins ? jobs.bits : 0;
  const TileRect rect = view.grid.at(tile);
  auto* const origins = reinterpret_cast<int32_t*>(words + size);
  masks.fill(view, rect, stream, layer);
  for (uint32_t i = threadIdx.x; i < size; i += kFrontThreads) {
    uint32_t word = 0;
    if (job.isNumber())
      word = view.numbers[size_t{job.plane} * view.values + begin + i];
    else
      for (uint32_t plane = 0; plane < job.planes(); ++plane) word |= static_cast<uint32_t>(view.bytes[size_t{job.plane + plane} * view.values + begin + i]) << 8 * plane;
    words[i] = word;
    if (hasOrigins) origins[i] = jobs.origins[begin + i];
  }
  __syncthreads();
  if (threadIdx.x < 32) {
    if (job.isNumber())
      goThroughTile(rect, masks, words, hasOrigins ? origins : nullptr, NumberRule{bits, job.kind == FrontKind::radius ? kRadiusCodeMax : ~0u});
    else if (job.kind == FrontKind::color)
      goThroughTile(rect, masks, words, nullptr, ColorRule{});
    else
      goThroughTile(rect, masks, words, nullptr, ChannelRule{});
  }
  __syncthreads();
  for (uint32_t i = threadIdx.x; i < size; i += kFrontThreads) job.values[begin + i] = words[i];
}

}  // namespace

void putFronts(const SheetView& view, const FrontJobs& jobs, cudaStream_t stream) {
  static_assert(FrontJobs::kMost * kCodedTilePixels * sizeof(uint32_t) <= 32 * 1024, "with what else there is, what a kernel has without asking for more");
  putDifferences<<<view.tiles() * view.layers, kPuttingThreads, jobs.count * static_cast<unsigned>(kCodedTilePixels * sizeof(uint32_t)), stream>>>(view, jobs);
  WARPSCOPE_CUDA_CHECK_LAUNCH();
}

void takeFronts(const SheetView& view, const FrontJobs& jobs, cudaStream_t stream) {
  constexpr unsigned kBytes = 2 * static_cast<unsigned>(kCodedTilePixels * sizeof(uint32_t));  // the less, the more tiles at once
  takeDifferences<<<dim3(view.tiles() * view.layers, jobs.count), kFrontThreads, kBytes, stream>>>(view, jobs);
  WARPSCOPE_CUDA_CHECK_LAUNCH();
}

}  // namespace warpscope
