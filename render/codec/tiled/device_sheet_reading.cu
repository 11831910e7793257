// Slots of models, shapes, planes: reading.
// See device_sheet.h.
#include <algorithm>
#include <cstring>

#include "render/codec/tiled/block_sums.cuh"
#include "render/codec/tiled/device_lanes.cuh"
#include "render/codec/tiled/device_sheet.h"
#include "render/codec/tiled/tile_threads.cuh"
#include "render/core/parallel.h"
#include "render/march/frame_segments.h"
#include "render/march/ray_pieces.h"

namespace warpscope {
namespace {

/// A block for each model: what a reader finds at each slot.
__global__ void __launch_bounds__(kAnsSymbols) findSlots(const uint16_t* frequencies, uint32_t* slots) {
  __shared__ uint32_t starts[kAnsSymbols + 1];
  BlockSums<kAnsSymbols> sums;
  uint32_t total;
  starts[threadIdx.x] = sums.before(frequencies[blockIdx.x * kAnsSymbols + threadIdx.x], total);
  starts[kAnsSymbols] = total;
  __syncthreads();
  if (starts[kAnsSymbols] != kAnsScale) return;
  for (uint32_t slot = threadIdx.x; slot < kAnsScale; slot += blockDim.x) {
    uint32_t low = 0, high = kAnsSymbols;  // the symbol is in [low, high)
    while (high - low > 1) {
      const uint32_t middle = (low + high) / 2;
      (starts[middle] <= slot ? low : high) = middle;
    }
    slots[blockIdx.x * kAnsScale + slot] = ansSlot(low, starts[low + 1] - starts[low], slot - starts[low]);
  }
}

/// What models are for a reader of streams. Reads what has one symbol alone without a stream.
struct ReaderModels {
  const uint32_t* slots;
  const uint16_t* frequencies;
  uint32_t* own = nullptr;  ///< kAnsScale places in shared memory

  /// The symbol that has all, or -1.
  __device__ int constant(uint32_t model) const {
    for (uint32_t s = threadIdx.x % 32; __any_sync(kAllLanes, s < kAnsSymbols); s += 32) {
      const uint32_t having = __ballot_sync(kAllLanes, frequencies[model * kAnsSymbols + s] == kAnsScale);
      if (having != 0) return static_cast<int>(s - threadIdx.x % 32 + __ffs(static_cast<int>(having)) - 1);
    }
    return -1;
  }
  __device__ bool isEmpty(uint32_t model) const {
    uint32_t any = 0;
    for (uint32_t s = threadIdx.x % 32; s < kAnsSymbols; s += 32) any |= frequencies[model * kAnsSymbols + s];
    return !__any_sync(kAllLanes, any != 0);
  }

  template <class T>
  __device__ void take(WarpReader& reader, uint32_t model, T* symbols, uint32_t size) const {
    if (size == 0) return;
    const int only = constant(model);
    if (only < 0 && !isEmpty(model) && reader.hasStream()) {
      __syncwarp();
      const auto* const from = reinterpret_cast<const uint4*>(slots + size_t{model} * kAnsScale);
      for (uint32_t i = threadIdx.x % 32; i < kAnsScale / 4; i += 32) reinterpret_cast<uint4*>(own)[i] = from[i];
      __syncwarp();
      return reader.take(own, symbols, size);
    }
    const uint32_t token = only < 0 ? 0 : static_cast<uint32_t>(only);
    if (only < 0) reader.blame();
    if constexpr (sizeof(T) > 1)
      if (restBits(token) > 0) {
        if (reader.hasStream()) return reader.takeRests(token, symbols, size);
        reader.blame();
      }
    for (uint32_t i = threadIdx.x % 32; i < size; i += 32) symbols[i] = static_cast<T>(token);
  }
};

/// Undoes what masks were changed by. False if they cover pixels outside. Counts become 1 or 0; `covered`: how many pixels are.
__device__ bool takeMask(const SheetView& view, const TileRect& rect, uint8_t* shape, uint32_t& covered) {
  const uint32_t lane = threadIdx.x, rowBytes = rect.maskRowBytes();
  uint32_t bits = 0, outside = 0;
  covered = 0;
  for (uint32_t y = 0; y < rect.height && lane < rowBytes; ++y) {
    bits ^= shape[y * rowBytes + lane];
    for (uint32_t i = 0; i < 8; ++i) {
      const uint32_t x = 8 * lane + i, isCovered = bits >> i & 1;
      if (x < rect.width)
        view.counts[view.pixel(rect, x, y)] = static_cast<uint8_t>(isCovered);
      else
        outside |= isCovered;
    }
    covered += __popc(bits);
  }
  covered = __reduce_add_sync(kAllLanes, covered);
  return !__any_sync(kAllLanes, outside != 0);
}

/// Rays' bytes, and counts. Returns whether any is not 0.
__device__ void takeRays(const SheetView& view, const TileRect& rect, const uint8_t* shape, uint8_t* rays) {
  const uint32_t y = threadIdx.x;
  uint32_t bits = prefixXor(y < rect.height ? shape[y * rect.width] : 0);
  for (uint32_t x = 0; x < rect.width && y < rect.height; ++x) {
    if (x > 0) bits ^= shape[y * rect.width + x];
    if ((bits & kUnusedRayBits) != 0) atomicOr(view.flags, kDamagedShapes);
    rays[view.pixel(rect, x, y)] = static_cast<uint8_t>(bits);
    view.counts[view.pixel(rect, x, y)] = static_cast<uint8_t>(RaySegmentCount::ofBits(static_cast<uint8_t>(bits)).count());
  }
}

/// A warp for each tile. `states`: where its first stream goes on.
__global__ void __launch_bounds__(32) readShapes(SheetView view, ReaderModels models, const StreamRead* reads, const uint16_t* packed, uint32_t most, uint8_t* rays,
                                                 LaneState* states, uint32_t* badStreams) {
  __shared__ __align__(16) uint32_t slots[kAnsScale];
  models.own = slots;
  const uint32_t tile = blockIdx.x, lane = threadIdx.x, streams = view.streams[tile];
  const TileRect rect = view.grid.at(tile);
  uint8_t* const shape = view.shape(0, tile);
  const uint32_t size = view.shapeSize(0, tile);
  const StreamRead read = reads[tile * view.layers];
  WarpReader reader(packed + read.offset / 2, streams > 0 ? read.length : 0);
  if (streams > 0)
    models.take(reader, 0, shape, size);
  else
    for (uint32_t i = lane; i < size; i += 32) shape[i] = 0;
  __syncwarp();
  bool isGood = true;
  if (view.hasMasks) {
    uint32_t covered = 0;
    isGood = takeMask(view, rect, shape, covered);
    __syncwarp();
    if (view.form.shapes > 1 && streams > 0) {
      uint8_t* const further = view.shape(1, tile);
      models.take(reader, 1, further, covered);
      __syncwarp();
      uint32_t last = 0;
      forCovered(view, rect, [&](size_t pixel, bool isCovered, uint32_t, uint32_t rank) {
        const uint32_t own = last ^ prefixXor(isCovered ? further[rank] : 0);
        if (isCovered) view.counts[pixel] = static_cast<uint8_t>(own < most ? 1 + own : 255);
        last = __shfl_sync(kAllLanes, own, 31);
      });
    }
  } else {
    takeRays(view, rect, shape, rays);
  }
  __syncwarp();
  uint32_t deepest = 0;
  for (uint32_t i = lane; i < rect.pixels(); i += 32) deepest = max(deepest, static_cast<uint32_t>(view.counts[view.pixel(rect, i % rect.width, i / rect.width)]));
  deepest = __reduce_max_sync(kAllLanes, deepest);
  // A tile of rays without segments that ended has a stream and no layers.
  const uint32_t wanted = !view.hasMasks && streams == 1 ? max(deepest, 1u) : deepest;
  isGood = isGood && deepest <= most && streams == wanted;
  if (lane == 0 && !isGood) atomicOr(view.flags, kDamagedShapes);
  states[tile * 32 + lane] = reader.state();
  const bool isBad = reader.isBad();
  if (lane == 0) badStreams[tile] = 0;
  __syncwarp();
  if (isBad) badStreams[tile] = 1;
}

/// A warp for each stream.
__global__ void __launch_bounds__(32) readPlanes(SheetView view, ReaderModels models, const StreamRead* reads, const uint16_t* packed, const LaneState* states,
                                                 const uint32_t* badStreams) {
  __shared__ __align__(16) uint32_t slots[kAnsScale];
  models.own = slots;
  const uint32_t stream = blockIdx.x, tile = stream / view.layers, layer = stream % view.layers;
  if (layer >= view.streams[tile] || !view.isFull() || (*view.flags & kDamagedShapes) != 0) return;
  const StreamRead read = reads[stream];
  WarpReader reader(packed + read.offset / 2, read.length);
  if (layer == 0) {
    reader.goOnAt(states[tile * 32 + threadIdx.x]);
    if (badStreams[tile] != 0) reader.blame();
  }
  const uint32_t size = view.sizeOf(stream);
  for (uint32_t plane = 0; plane < view.form.numbers; ++plane) models.take(reader, view.modelOf(layer, plane), view.number(plane, stream), size);
  for (uint32_t plane = 0; plane < view.form.bytes; ++plane) models.take(reader, view.modelOf(layer, view.form.numbers + plane), view.byte(plane, stream), size);
  if (!reader.isSound() && threadIdx.x == 0) atomicOr(view.flags, kDamagedStreams);
}

}  // namespace

bool DeviceSheet::upload(const SheetHead& head) {
  const uint32_t tiles = view_.tiles(), streams = tiles * view_.layers;
  const size_t models = head.models.size(), frequencyBytes = models * kAnsSymbols * sizeof(uint16_t), readBytes = streams * sizeof(StreamRead);
  const std::byte* const first = head.streams.empty() ? nullptr : head.streams.front().data();
  const size_t bytes = head.streams.empty() ? 0 : static_cast<size_t>(head.streams.back().data() + head.streams.back().size() - first);
  const size_t tileBytes = (tiles + 7) / 8 * 8;
  WARPSCOPE_CUDA_CHECK(cudaStreamSynchronize(stream_));  // what was there may still be read
  host_.resize(frequencyBytes + readBytes + tileBytes + bytes);
  std::byte* const reads = host_.data() + frequencyBytes;
  std::byte* const ofTiles = reads + readBytes;
  std::byte* const packed = ofTiles + tileBytes;
  for (size_t model = 0; model < models; ++model)
    std::memcpy(host_.data() + model * kAnsSymbols * sizeof(uint16_t), head.models[model].frequencies().data(), kAnsSymbols * sizeof(uint16_t));
  std::memset(reads, 0, readBytes);
  for (uint32_t tile = 0; tile < tiles; ++tile) {
    ofTiles[tile] = static_cast<std::byte>(head.streamsOf(tile));
    if (head.streamsOf(tile) > view_.layers) return false;
    for (uint32_t layer = 0; layer < head.streamsOf(tile); ++layer) {
      const std::span<const std::byte> own = head.streams[head.starts[tile] + layer];
      if (own.size() % sizeof(uint16_t) != 0) return false;
      const StreamRead read{static_cast<uint32_t>(own.data() - first), static_cast<uint32_t>(own.size())};
      std::memcpy(reads + (size_t{tile} * view_.layers + layer) * sizeof read, &read, sizeof read);
    }
  }
  constexpr size_t kCopied = size_t{1} << 18;  // at once: one core would take longer than the link
  parallelForRanges((bytes + kCopied - 1) / kCopied, 1, [&](size_t begin, size_t end) {
    std::memcpy(packed + begin * kCopied, first + begin * kCopied, std::min(end * kCopied, bytes) - begin * kCopied);
  });
  frequencies_.reserve(models * kAnsSymbols);
  slots_.reserve(models * kAnsScale);
  reads_.reserve(streams);
  packed_.reserve(bytes / 2 + 1);
  laneStates_.reserve(size_t{tiles} * kAnsLanes);
  bad_.reserve(tiles);
  const auto put = [&](void* to, const std::byte* from, size_t count) {
    if (count > 0) WARPSCOPE_CUDA_CHECK(cudaMemcpyAsync(to, from, count, cudaMemcpyHostToDevice, stream_));
  };
  put(frequencies_.data(), host_.data(), frequencyBytes);
  put(reads_.data(), reads, readBytes);
  put(streams_.data(), ofTiles, tiles);
  put(packed_.data(), packed, bytes);
  findSlots<<<static_cast<unsigned>(models), kAnsSymbols, 0, stream_>>>(frequencies_.data(), slots_.data());
  WARPSCOPE_CUDA_CHECK_LAUNCH();
  return true;
}

void DeviceSheet::takeShapes(uint32_t most, uint8_t* rays) {
  readShapes<<<view_.tiles(), 32, 0, stream_>>>(view_, {slots_.data(), frequencies_.data()}, reads_.data(), packed_.data(), most, rays, laneStates_.data(), bad_.data());
  WARPSCOPE_CUDA_CHECK_LAUNCH();
}

void DeviceSheet::takePlanes() {
  readPlanes<<<view_.tiles() * view_.layers, 32, 0, stream_>>>(view_, {slots_.data(), frequencies_.data()}, reads_.data(), packed_.data(), laneStates_.data(), bad_.data());
  WARPSCOPE_CUDA_CHECK_LAUNCH();
}

}  // namespace warpscope
