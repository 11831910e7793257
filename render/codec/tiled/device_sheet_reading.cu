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

constexpr int kUsualModel = -1, kEmptyModel = -2;  // else a model has one symbol alone

/// A block for each model: what a reader finds at each slot, and what model it is.
__global__ void __launch_bounds__(kAnsSymbols) findSlots(const uint16_t* frequencies, uint32_t* slots, int* kinds) {
  __shared__ uint32_t starts[kAnsSymbols + 1];
  BlockSums<kAnsSymbols> sums;
  uint32_t total;
  const uint32_t own = frequencies[blockIdx.x * kAnsSymbols + threadIdx.x];
  starts[threadIdx.x] = sums.before(own, total);
  starts[kAnsSymbols] = total;
  if (threadIdx.x == 0) kinds[blockIdx.x] = total > 0 ? kUsualModel : kEmptyModel;
  __syncthreads();
  if (own == kAnsScale) kinds[blockIdx.x] = static_cast<int>(threadIdx.x);
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

/// Streams of as many neighbouring tiles are read by the warps of a block: they share a model's slots, of which there are 16 KiB.
constexpr uint32_t kTilesOfBlock = 4;
constexpr unsigned kReadingThreads = 32 * kTilesOfBlock;

/// What models are for readers of streams. All threads of a block go through the same models together.
struct ReaderModels {
  const uint32_t* slots;
  const int* kinds;
  uint32_t count;  ///< that there are: not always those of any layer, though a tile has a stream
};

class BlockModels {
 public:
  /// `own`: kAnsScale places in shared memory. Looks ahead to the first.
  __device__ BlockModels(const ReaderModels& models, uint32_t* own, uint32_t first) : models_(models), own_(own) { look(first); }

  /// Goes on to the model that was looked at last, and looks at `next`.
  __device__ void goOn(uint32_t next) {
    kind_ = nextKind_;
    __syncthreads();  // nobody reads the one before any more
    if (kind_ == kUsualModel)
#pragma unroll
      for (uint32_t k = 0; k < kOwn; ++k) reinterpret_cast<uint4*>(own_)[k * kReadingThreads + threadIdx.x] = next_[k];
    __syncthreads();
    look(next);
  }

  /// Symbols of the model, by a warp. What has one symbol alone is read without a stream.
  template <class T>
  __device__ void take(WarpReader& reader, T* symbols, uint32_t size) const {
    if (size == 0) return;
    if (kind_ == kUsualModel && reader.hasStream()) return reader.take(own_, symbols, size);
    const uint32_t token = kind_ < 0 ? 0 : static_cast<uint32_t>(kind_);
    if (kind_ < 0) reader.blame();
    if constexpr (sizeof(T) > 1)
      if (restBits(token) > 0) {
        if (reader.hasStream()) return reader.takeRests(token, symbols, size);
        reader.blame();
      }
    for (uint32_t i = threadIdx.x % 32; i < size; i += 32) symbols[i] = static_cast<T>(token);
  }

 private:
  static constexpr uint32_t kOwn = kAnsScale / 4 / kReadingThreads;

  __device__ void look(uint32_t model) {
    nextKind_ = model < models_.count ? models_.kinds[model] : kEmptyModel;
    if (nextKind_ != kUsualModel) return;
    const auto* const from = reinterpret_cast<const uint4*>(models_.slots + size_t{model} * kAnsScale) + threadIdx.x;
#pragma unroll
    for (uint32_t k = 0; k < kOwn; ++k) next_[k] = from[k * kReadingThreads];
  }

  const ReaderModels models_;
  uint32_t* const own_;
  uint4 next_[kOwn];
  int kind_ = kEmptyModel, nextKind_ = kEmptyModel;
};

/// Undoes what masks were changed by. False if they cover pixels outside. Counts become 1 or 0; `covered`: how many pixels are.
__device__ bool takeMask(const SheetView& view, const TileRect& rect, uint8_t* shape, uint32_t& covered) {
  const uint32_t lane = threadIdx.x % 32, rowBytes = rect.maskRowBytes();
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

/// Rays' bytes, and counts. Returns the largest of those. False in `isGood` where a byte is none of a ray.
__device__ uint32_t takeRays(const SheetView& view, const TileRect& rect, const uint8_t* shape, uint8_t* rays, bool& isGood) {
  constexpr uint32_t kRows = 4;  // at once, a byte each
  const uint32_t lane = threadIdx.x % 32;
  const uint32_t down = prefixXor(lane < rect.height ? shape[lane * rect.width] : 0);  // the first of row `lane`
  uint32_t deepest = 0, all = 0;
  for (uint32_t y = 0; y < rect.height; y += kRows) {
    uint32_t before = 0;
    for (uint32_t k = 0; k < kRows; ++k) before |= __shfl_sync(kAllLanes, down, (y + k) % 32) << 8 * k;
    for (uint32_t begin = 0; begin < rect.width; begin += 32) {
      const uint32_t x = begin + lane;
      uint32_t changes = 0;
      for (uint32_t k = 0; k < kRows; ++k)
        if (x > 0 && x < rect.width && y + k < rect.height) changes |= static_cast<uint32_t>(shape[(y + k) * rect.width + x]) << 8 * k;
      const uint32_t bits = before ^ prefixXor(changes);
      before = __shfl_sync(kAllLanes, bits, 31);
      for (uint32_t k = 0; k < kRows; ++k) {
        if (x >= rect.width || y + k >= rect.height) continue;
        const auto own = static_cast<uint8_t>(bits >> 8 * k);
        const auto count = static_cast<uint32_t>(RaySegmentCount::ofBits(own).count());
        rays[view.pixel(rect, x, y + k)] = own;
        view.counts[view.pixel(rect, x, y + k)] = static_cast<uint8_t>(count);
        deepest = max(deepest, count);
        all |= own;
      }
    }
  }
  isGood = !__any_sync(kAllLanes, (all & kUnusedRayBits) != 0);
  return __reduce_max_sync(kAllLanes, deepest);
}

/// A warp for each tile. `states`: where its first stream goes on.
__global__ void __launch_bounds__(kReadingThreads) readShapes(const __grid_constant__ SheetView view, ReaderModels all, const StreamRead* reads, const uint16_t* packed, uint32_t most, uint8_t* rays,
                                                              LaneState* states, uint32_t* badStreams) {
  __shared__ __align__(16) uint32_t slots[kAnsScale];
  BlockModels models(all, slots, 0);
  const bool hasFurther = view.hasMasks && view.form.shapes > 1;
  models.goOn(hasFurther ? 1 : 0);
  const uint32_t tile = blockIdx.x * kTilesOfBlock + threadIdx.x / 32, lane = threadIdx.x % 32;
  const bool isInside = tile < view.tiles();
  const uint32_t streams = isInside ? view.streams[tile] : 0;
  const TileRect rect = view.grid.at(isInside ? tile : 0);
  uint8_t* const shape = view.shape(0, isInside ? tile : 0);
  const StreamRead read = streams > 0 ? reads[tile * view.layers] : StreamRead{};
  WarpReader reader(packed + read.offset / 2, read.length);
  const uint32_t size = isInside ? view.shapeSize(0, tile) : 0;
  if (streams > 0)
    models.take(reader, shape, size);
  else
    for (uint32_t i = lane; i < size; i += 32) shape[i] = 0;
  __syncwarp();
  bool isGood = true;
  uint32_t deepest = 0, covered = 0;
  if (isInside && view.hasMasks) {
    isGood = takeMask(view, rect, shape, covered);
    deepest = covered > 0 ? 1 : 0;
  } else if (isInside) {
    deepest = takeRays(view, rect, shape, rays, isGood);
  }
  if (hasFurther) {
    models.goOn(0);
    __syncwarp();
    if (isInside && streams > 0) {
      uint8_t* const further = view.shape(1, tile);
      models.take(reader, further, covered);
      __syncwarp();
      uint32_t last = 0;
      forCovered(view, rect, [&](size_t pixel, bool isCovered, uint32_t, uint32_t rank) {
        const uint32_t own = last ^ prefixXor(isCovered ? further[rank] : 0);
        const uint32_t count = own < most ? 1 + own : 255;
        if (isCovered) {
          view.counts[pixel] = static_cast<uint8_t>(count);
          deepest = max(deepest, count);
        }
        last = __shfl_sync(kAllLanes, own, 31);
      });
      deepest = __reduce_max_sync(kAllLanes, deepest);
    }
  }
  if (!isInside) return;
  // A tile of rays without segments that ended has a stream and no layers.
  const uint32_t wanted = !view.hasMasks && streams == 1 ? max(deepest, 1u) : deepest;
  isGood = isGood && deepest <= most && streams == wanted;
  if (lane == 0 && !isGood) atomicOr(view.flags, kDamagedShapes);
  states[tile * 32 + lane] = reader.state();
  const bool isBad = __any_sync(kAllLanes, reader.isBad()) != 0;
  if (lane == 0) badStreams[tile] = isBad ? 1 : 0;
}

/// A warp for each stream. Blocks of the layer in front, whose streams are the longest, come first.
__global__ void __launch_bounds__(kReadingThreads) readPlanes(const __grid_constant__ SheetView view, ReaderModels all, const StreamRead* reads, const uint16_t* packed, const LaneState* states,
                                                              const uint32_t* badStreams) {
  __shared__ __align__(16) uint32_t slots[kAnsScale];
  if (!view.isFull() || (*view.flags & kDamagedShapes) != 0) return;
  const uint32_t layer = blockIdx.y, tile = blockIdx.x * kTilesOfBlock + threadIdx.x / 32;
  const bool isThere = tile < view.tiles() && layer < view.streams[tile];
  if (__syncthreads_or(isThere) == 0) return;
  const uint32_t stream = isThere ? tile * view.layers + layer : 0, size = isThere ? view.sizeOf(stream) : 0;
  const StreamRead read = isThere ? reads[stream] : StreamRead{};
  WarpReader reader(packed + read.offset / 2, read.length);
  if (isThere && layer == 0) {
    reader.goOnAt(states[tile * 32 + threadIdx.x % 32]);
    if (badStreams[tile] != 0) reader.blame();
  }
  BlockModels models(all, slots, view.modelOf(layer, 0));
  for (uint32_t plane = 0; plane < view.form.planes(); ++plane) {
    models.goOn(view.modelOf(layer, min(plane + 1, view.form.planes() - 1)));
    if (plane < view.form.numbers)
      models.take(reader, view.number(plane, stream), size);
    else
      models.take(reader, view.byte(plane - view.form.numbers, stream), size);
  }
  if (isThere && !reader.isSound() && threadIdx.x % 32 == 0) atomicOr(view.flags, kDamagedStreams);
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
  kinds_.reserve(models);
  models_ = static_cast<uint32_t>(models);
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
  findSlots<<<static_cast<unsigned>(models), kAnsSymbols, 0, stream_>>>(frequencies_.data(), slots_.data(), kinds_.data());
  WARPSCOPE_CUDA_CHECK_LAUNCH();
  return true;
}

void DeviceSheet::takeShapes(uint32_t most, uint8_t* rays) {
  readShapes<<<cuda::blocksFor(view_.tiles(), kTilesOfBlock), kReadingThreads, 0, stream_>>>(view_, {slots_.data(), kinds_.data(), models_}, reads_.data(), packed_.data(), most, rays, laneStates_.data(), bad_.data());
  WARPSCOPE_CUDA_CHECK_LAUNCH();
}

void DeviceSheet::takePlanes() {
  readPlanes<<<dim3(cuda::blocksFor(view_.tiles(), kTilesOfBlock), view_.layers), kReadingThreads, 0, stream_>>>(view_, {slots_.data(), kinds_.data(), models_}, reads_.data(), packed_.data(), laneStates_.data(), bad_.data());
  WARPSCOPE_CUDA_CHECK_LAUNCH();
}

}  // namespace warpscope
