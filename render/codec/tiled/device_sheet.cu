// Counts, masks, models, streams: writing. Reading: device_sheet_reading.cu.
// See device_sheet.h.
#include "render/codec/tiled/device_sheet.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <type_traits>

#include "render/codec/tiled/block_sums.cuh"
#include "render/codec/tiled/device_hash.cuh"
#include "render/codec/tiled/device_lanes.cuh"
#include "render/codec/tiled/symbol_counts.cuh"
#include "render/codec/tiled/tile_threads.cuh"
#include "render/cuda/pinned_memory.h"

namespace warpscope {
namespace {

constexpr uint32_t kMostLayers = 32;  // that a byte of a pixel's counts says

/// Words that a value, and a tile's shapes, take at most (mostSheetBytes).
__host__ __device__ uint32_t valueWords(const SheetForm& form) { return (form.planes() * (kAnsBits + 1) + form.numbers * kMostTokenBits + 15) / 16; }
__host__ __device__ uint32_t shapeWords(const SheetForm& form) { return form.shapes * (kCodedTilePixels * (kAnsBits + 1) / 16); }
/// Behind the room of a stream.
__host__ __device__ size_t endOfRoom(const SheetView& view, uint32_t stream) {
  return size_t{view.begins[stream + 1]} * valueWords(view.form) + size_t{stream / view.layers + 1} * shapeWords(view.form) + size_t{stream + 1} * 2;
}

constexpr uint32_t kCountedRows = 4;  // by a thread
constexpr uint32_t kCountingThreads = kCodedTileWidth * kCodedTileHeight / kCountedRows;

/// A block for each tile, a thread for some rows of a column. `layersUsed`: of any tile.
__global__ void __launch_bounds__(kCountingThreads) countTiles(const __grid_constant__ SheetView view, uint32_t* layersUsed) {
  __shared__ uint32_t sizes[kMostLayers][kCodedTileHeight];  // of each row
  const TileRect rect = view.grid.at(blockIdx.x);
  const uint32_t x = threadIdx.x, column = x % kCodedTileWidth, top = x / kCodedTileWidth * kCountedRows;
  for (uint32_t i = x; i < view.layers * kCodedTileHeight; i += kCountingThreads) sizes[i / kCodedTileHeight][i % kCodedTileHeight] = 0;
  uint32_t counts[kCountedRows];  // one load does not wait for another
#pragma unroll
  for (uint32_t k = 0; k < kCountedRows; ++k) counts[k] = column < rect.width && top + k < rect.height ? view.counts[view.pixel(rect, column, top + k)] : 0;
  __syncthreads();
#pragma unroll
  for (uint32_t k = 0; k < kCountedRows; ++k)
    for (uint32_t layer = 0; layer < view.layers; ++layer) {
      const uint32_t covered = __popc(__ballot_sync(kAllLanes, counts[k] > layer));
      if (covered == 0) break;
      if (x % 32 == 0) atomicAdd(&sizes[layer][top + k], covered);
    }
  __syncthreads();
  if (x < rect.height) {
    uint32_t sum = 0;
    for (uint32_t layer = 0; layer < view.layers; ++layer) sum += sizes[layer][x];
    view.rowBegins[size_t{rect.y0 + x} * view.grid.columns() + blockIdx.x % view.grid.columns()] = sum;
  }
  if (x < view.layers) {
    const uint32_t stream = blockIdx.x * view.layers + x;
    uint32_t size = 0;
    for (uint32_t y = 0; y < kCodedTileHeight; ++y) {
      view.rowRanks[size_t{stream} * kCodedTileHeight + y] = size;
      size += sizes[x][y];
    }
    view.begins[stream] = size;
    if (size > 0) atomicMax(layersUsed, x + 1);
  }
}

constexpr int kSumThreads = 1024;

/// A block for each of two arrays, of sizes, which become where each begins.
__global__ void __launch_bounds__(kSumThreads) findBegins(uint32_t* streams, uint32_t streamCount, uint32_t* rows, uint32_t rowCount) {
  BlockSums<kSumThreads> sums;
  if (blockIdx.x == 0)
    sums.ofArray(streams, streams, streamCount);
  else
    sums.ofArray(rows, rows, rowCount);
}

/// What the byte of a mask at a place is.
__device__ uint32_t maskByte(const SheetView& view, const TileRect& rect, uint32_t byte, uint32_t y) {
  uint32_t bits = 0;
  for (uint32_t i = 0; i < 8; ++i)
    if (8 * byte + i < rect.width && view.counts[view.pixel(rect, 8 * byte + i, y)] > 0) bits |= 1u << i;
  return bits;
}

/// A block for each tile.
__global__ void putMasks(const __grid_constant__ SheetView view) {
  const uint32_t tile = blockIdx.x;
  const TileRect rect = view.grid.at(tile);
  const uint32_t rowBytes = rect.maskRowBytes();
  uint8_t* const shape = view.shape(0, tile);
  for (uint32_t i = threadIdx.x; i < rowBytes * rect.height; i += blockDim.x) {
    const uint32_t y = i / rowBytes, byte = i % rowBytes;
    shape[i] = static_cast<uint8_t>(maskByte(view, rect, byte, y) ^ (y > 0 ? maskByte(view, rect, byte, y - 1) : 0));
  }
  if (threadIdx.x == 0) {
    uint32_t streams = 0;
    while (streams < view.layers && view.sizeOf(tile * view.layers + streams) > 0) ++streams;
    view.streams[tile] = static_cast<uint8_t>(streams);
  }
}

/// How many further layers covered pixels have. A warp for each tile.
__global__ void putFurther(const __grid_constant__ SheetView view) {
  const uint32_t tile = blockIdx.x;
  uint8_t* const shape = view.shape(1, tile);
  uint32_t last = 0;
  forCovered(view, view.grid.at(tile), [&](size_t pixel, bool isCovered, uint32_t covered, uint32_t rank) {
    const uint32_t further = isCovered ? view.counts[pixel] - 1u : 0;
    const uint32_t others = covered & lanesBelow();
    const uint32_t beside = __shfl_sync(kAllLanes, further, others != 0 ? 31 - __clz(static_cast<int>(others)) : 0);
    if (isCovered) shape[rank] = static_cast<uint8_t>(further ^ (others != 0 ? beside : last));
    last = __shfl_sync(kAllLanes, further, 31 - __clz(static_cast<int>(covered)));
  });
}

/// A block for each stream and each of the shapes and planes that are not `counted` (a bit each, shapes first): how often each symbol of its model occurs.
__global__ void __launch_bounds__(kAnsSymbols) countSymbols(const __grid_constant__ SheetView view, uint32_t counted) {
  __shared__ uint32_t counts[kAnsSymbols];
  const uint32_t stream = blockIdx.x, tile = stream / view.layers, layer = stream % view.layers;
  if (layer >= view.streams[tile]) return;
  uint32_t part = 0;
  for (uint32_t before = blockIdx.y; (counted >> part & 1) != 0 || before-- > 0;) ++part;
  const auto add = [&](uint32_t model, uint32_t size, const auto& symbolAt) {
    constexpr uint32_t kOwn = kCodedTilePixels / kAnsSymbols;  // one load does not wait for another
    uint32_t symbols[kOwn];
#pragma unroll
    for (uint32_t k = 0; k < kOwn; ++k) {
      const uint32_t i = k * kAnsSymbols + threadIdx.x;
      symbols[k] = i < size ? symbolAt(i) : kAnsSymbols;
    }
    counts[threadIdx.x] = 0;
    __syncthreads();
#pragma unroll
    for (uint32_t k = 0; k < kOwn; ++k) countSymbol(counts, symbols[k]);
    __syncthreads();
    if (counts[threadIdx.x] > 0) atomicAdd(&view.histograms[model * kAnsSymbols + threadIdx.x], counts[threadIdx.x]);
  };
  if (part < view.form.shapes) {
    if (layer > 0) return;
    const uint8_t* const symbols = view.shape(part, tile);
    return add(part, view.shapeSize(part, tile), [symbols](uint32_t i) { return symbols[i]; });
  }
  const uint32_t plane = part - view.form.shapes, model = view.modelOf(layer, plane);
  if (plane < view.form.numbers) {
    const uint32_t* const numbers = view.number(plane, stream);
    add(model, view.sizeOf(stream), [numbers](uint32_t i) { return tokenOf(numbers[i]); });
  } else {
    const uint8_t* const bytes = view.byte(plane - view.form.numbers, stream);
    add(model, view.sizeOf(stream), [bytes](uint32_t i) { return bytes[i]; });
  }
}

/// A block for each model.
__global__ void __launch_bounds__(kAnsSymbols) scaleModels(const uint32_t* histograms, uint16_t* frequencies, AnsWriterShare* shares) {
  BlockSums<kAnsSymbols> sums;
  const uint32_t symbol = threadIdx.x, count = histograms[blockIdx.x * kAnsSymbols + symbol];
  uint32_t total, sum;
  sums.before(count, total);
  uint16_t own = total > 0 ? ansRounded(count, total) : 0;
  uint32_t start = sums.before(own, sum);
  while (total > 0 && sum != kAnsScale) {  // ansEven(), by all threads
    const uint32_t first = kAnsSymbols - 1 - symbol, most = sums.greatest(uint32_t{own} * kAnsSymbols + first);  // of equals the first
    if (most % kAnsSymbols == first) own = ansEvener(own, sum);
    start = sums.before(own, sum);
  }
  frequencies[blockIdx.x * kAnsSymbols + symbol] = own;
  shares[blockIdx.x * kAnsSymbols + symbol] = AnsWriterShare::of({start, own});
}

/// Symbols of a model whose shares are `own`, in shared memory.
__device__ void putBytes(WarpWriter& writer, const AnsWriterShare* own, const uint8_t* symbols, uint32_t size) {
  fromTheEnd(
      symbols, size, [&](uint32_t symbol) { return own[symbol]; }, [&](const AnsWriterShare& share, bool isActive) { writer.put(share, isActive); });
}

/// The same of numbers. `takesBits`: their tokens do.
__device__ void putNumbers(WarpWriter& writer, const AnsWriterShare* own, const uint32_t* numbers, uint32_t size, bool takesBits) {
  struct Ready {
    AnsWriterShare share;
    uint32_t number, rest;  // bits of it that the token does not say
    bool hasRests;          // some lane's
  };
  fromTheEnd(
      numbers, size,
      [&](uint32_t number) {
        const uint32_t token = tokenOf(number), rest = restBits(token);
        return Ready{own[token], number, rest, __any_sync(kAllLanes, rest > 0) != 0};
      },
      [&](const Ready& ready, bool isActive) {
        if (ready.hasRests) {
          const uint32_t first = min(ready.rest, kAnsRestBits);
          if (__any_sync(kAllLanes, ready.rest > first)) writer.putBits(ready.number >> kAnsRestBits, ready.rest - first);
          writer.putBits(ready.number, first);
        }
        if (takesBits) writer.put(ready.share, isActive);
      });
}

/// A warp for each stream. Words go to the end of the stream's room.
__global__ void __launch_bounds__(32) writeStreams(const __grid_constant__ SheetView view, const AnsWriterShare* shares, uint16_t* words, uint32_t* wordCounts, uint32_t* states, uint32_t* lengths) {
  __shared__ AnsWriterShare own[kAnsSymbols];
  constexpr uint32_t kOwn = kAnsSymbols / 32;
  const uint32_t stream = blockIdx.x, tile = stream / view.layers, layer = stream % view.layers, lane = threadIdx.x;
  if (lane == 0) lengths[stream] = 0;
  if (layer >= view.streams[tile]) return;
  const uint32_t size = view.sizeOf(stream);
  WarpWriter writer(words + endOfRoom(view, stream));
  // Shapes, numbers, bytes: from the end to the front. What is known of the next one's model is loaded meanwhile.
  const uint32_t parts = view.form.shapes + view.form.planes(), front = layer > 0 ? view.form.shapes : 0;
  AnsWriterShare next[kOwn];
  const auto load = [&](uint32_t part) {
    const AnsWriterShare* const from = shares + size_t{part < view.form.shapes ? part : view.modelOf(layer, part - view.form.shapes)} * kAnsSymbols + lane;
#pragma unroll
    for (uint32_t k = 0; k < kOwn; ++k) next[k] = from[k * 32];
  };
  load(parts - 1);
  for (uint32_t part = parts; part-- > front;) {
    bool hasAll = false;
    __syncwarp();
#pragma unroll
    for (uint32_t k = 0; k < kOwn; ++k) {
      own[k * 32 + lane] = next[k];
      hasAll |= next[k].frequency() == kAnsScale;
    }
    __syncwarp();
    const bool takesBits = !__any_sync(kAllLanes, hasAll);  // the only symbol takes none
    if (part > front) load(part - 1);
    const uint32_t plane = part - view.form.shapes;
    if (part < view.form.shapes) {
      if (takesBits) putBytes(writer, own, view.shape(part, tile), view.shapeSize(part, tile));
    } else if (plane < view.form.numbers) {
      putNumbers(writer, own, view.number(plane, stream), size, takesBits);
    } else if (takesBits) {
      putBytes(writer, own, view.byte(plane - view.form.numbers, stream), size);
    }
  }
  states[stream * 32 + lane] = writer.state();
  const bool isEmpty = writer.count() == 0 && __all_sync(kAllLanes, writer.state() == kAnsLow);
  if (lane != 0) return;
  wordCounts[stream] = writer.count();
  lengths[stream] = isEmpty ? 0 : static_cast<uint32_t>(kAnsStateBytes + 2 * writer.count());
}

/// What the host is told before streams, one behind the other: frequencies of models, lengths of streams, how many bytes they have in all, layers that there are, and
/// how many streams each tile has.
struct SheetHeads {
  uint32_t models, streams, tiles;

  __host__ __device__ size_t lengthsAt() const { return size_t{models} * kAnsSymbols * sizeof(uint16_t); }
  __host__ __device__ size_t totalsAt() const { return lengthsAt() + size_t{streams} * sizeof(uint32_t); }
  __host__ __device__ size_t tilesAt() const { return totalsAt() + 2 * sizeof(uint32_t); }
  __host__ __device__ size_t bytes() const { return tilesAt() + tiles; }

  static SheetHeads of(const SheetView& view) { return {view.models(), view.tiles() * view.layers, view.tiles()}; }
};

/// One block finds where streams begin among all, and writes to the host's memory: what waits for a copy more waits longer.
__global__ void __launch_bounds__(kSumThreads) tellHeads(SheetHeads heads, const uint16_t* frequencies, const uint32_t* lengths, uint32_t* offsets, const uint32_t* layers,
                                                        const uint8_t* streamsOfTiles, std::byte* told) {
  BlockSums<kSumThreads> sums;
  sums.ofArray(lengths, offsets, heads.streams);
  const auto tell = [&](const auto* from, size_t at, uint32_t count) {
    auto* const to = reinterpret_cast<std::remove_cvref_t<decltype(*from)>*>(told + at);
    for (uint32_t i = threadIdx.x; i < count; i += kSumThreads) to[i] = from[i];
  };
  tell(reinterpret_cast<const uint32_t*>(frequencies), 0, heads.models * kAnsSymbols / 2);
  tell(lengths, heads.lengthsAt(), heads.streams);
  tell(streamsOfTiles, heads.tilesAt(), heads.tiles);
  __syncthreads();
  tell(offsets + heads.streams, heads.totalsAt(), 1);
  tell(layers, heads.totalsAt() + sizeof(uint32_t), 1);
}

/// A block for each stream.
__global__ void gatherStreams(const __grid_constant__ SheetView view, const uint16_t* words, const uint32_t* wordCounts, const uint32_t* states, const uint32_t* lengths, const uint32_t* offsets,
                              uint16_t* out) {
  const uint32_t stream = blockIdx.x;
  if (lengths[stream] == 0) return;
  uint16_t* const own = out + offsets[stream] / 2;
  const uint16_t* const from = words + endOfRoom(view, stream) - wordCounts[stream];
  if (threadIdx.x < 2 * kAnsLanes) own[threadIdx.x] = static_cast<uint16_t>(states[stream * kAnsLanes + threadIdx.x / 2] >> 16 * (threadIdx.x % 2));
  for (uint32_t i = threadIdx.x; i < wordCounts[stream]; i += blockDim.x) own[2 * kAnsLanes + i] = from[i];
}

/// Words of a payload whose first is `skipped` bytes behind `first`, which is aligned.
__global__ void sumWords(const uint32_t* first, uint32_t skipped, SummedWords words, unsigned long long* sum) {
  uint64_t own = 0;
  for (size_t i = size_t{blockIdx.x} * blockDim.x + threadIdx.x; i < words.count(); i += size_t{gridDim.x} * blockDim.x) {
    const uint32_t shift = skipped % 4 * 8;
    const uint32_t* const at = first + skipped / 4 + 2 * i;
    const uint32_t lower = at[0], upper = at[1], behind = shift > 0 ? at[2] : 0;
    own += placedHash(__funnelshift_r(lower, upper, shift) | uint64_t{__funnelshift_r(upper, behind, shift)} << 32, words.begin + i);
  }
  addHash(own, sum);
}

}  // namespace

DeviceSheet::DeviceSheet(cudaStream_t stream, cudaStream_t beside) : stream_(stream), beside_(beside), host_(TransferAllocator<std::byte>(cuda::pinnedMemory())) {}

const SheetView& DeviceSheet::begin(const TileGrid& grid, const SheetForm& form, uint32_t layers, bool hasMasks) {
  const size_t pixels = size_t{grid.width} * grid.height, tiles = grid.count();
  view_ = {grid, form, std::clamp(layers, 1u, kMostLayers - 1), hasMasks};
  const size_t streams = tiles * view_.layers;
  counts_.reserve(pixels);
  begins_.reserve(streams + 1);
  rowRanks_.reserve(streams * kCodedTileHeight);
  view_.rowRanks = rowRanks_.data();
  rowBegins_.reserve(size_t{grid.height} * grid.columns() + 1);
  streams_.reserve(tiles);
  for (uint32_t shape = 0; shape < form.shapes; ++shape) shapes_[shape].reserve(tiles * kCodedTilePixels);
  constexpr size_t kFlags = 2;  // SheetFlag; layers that there are
  flags_.reserve(kFlags);
  WARPSCOPE_CUDA_CHECK(cudaMemsetAsync(flags_.data(), 0, kFlags * sizeof(uint32_t), stream_));
  if (hasMasks) WARPSCOPE_CUDA_CHECK(cudaMemsetAsync(counts_.data(), 0, pixels, stream_));  // else each pixel gets its own
  view_.counts = counts_.data();
  view_.begins = begins_.data();
  view_.rowBegins = rowBegins_.data();
  view_.streams = streams_.data();
  view_.shapes[0] = shapes_[0].data();
  view_.shapes[1] = shapes_[1].data();
  view_.flags = flags_.data();
  return view_;
}

const SheetView& DeviceSheet::reserveValues(uint32_t values) {
  numbers_.reserve(size_t{values} * view_.form.numbers);
  bytes_.reserve(size_t{values} * view_.form.bytes);
  view_.values = values;
  view_.numbers = numbers_.data();
  view_.bytes = bytes_.data();
  return view_;
}

void DeviceSheet::count() {
  countTiles<<<view_.tiles(), kCountingThreads, 0, stream_>>>(view_, view_.flags + 1);
  WARPSCOPE_CUDA_CHECK_LAUNCH();
  findBegins<<<2, kSumThreads, 0, stream_>>>(view_.begins, view_.tiles() * view_.layers, view_.rowBegins, view_.grid.height * view_.grid.columns());
  WARPSCOPE_CUDA_CHECK_LAUNCH();
}

void DeviceSheet::makeMasks() {
  putMasks<<<view_.tiles(), 256, 0, stream_>>>(view_);
  WARPSCOPE_CUDA_CHECK_LAUNCH();
  if (view_.form.shapes < 2) return;
  putFurther<<<view_.tiles(), 32, 0, stream_>>>(view_);
  WARPSCOPE_CUDA_CHECK_LAUNCH();
}

const SheetView& DeviceSheet::clearHistograms() {
  const size_t symbols = size_t{view_.models()} * kAnsSymbols;
  histograms_.reserve(symbols);
  view_.histograms = histograms_.data();
  WARPSCOPE_CUDA_CHECK(cudaMemsetAsync(histograms_.data(), 0, symbols * sizeof(uint32_t), stream_));
  return view_;
}

void DeviceSheet::write(uint32_t counted) {
  const uint32_t streams = view_.tiles() * view_.layers, models = view_.models();
  frequencies_.reserve(size_t{models} * kAnsSymbols);
  shares_.reserve(size_t{models} * kAnsSymbols);
  states_.reserve(size_t{streams} * kAnsLanes);
  wordCounts_.reserve(streams);
  lengths_.reserve(streams);
  offsets_.reserve(streams + 1);
  const size_t room = size_t{view_.values} * valueWords(view_.form) + size_t{view_.tiles()} * shapeWords(view_.form) + size_t{streams} * 2;
  words_.reserve(room);
  packed_.reserve(room + size_t{streams} * 2 * kAnsLanes + 2);  // words that are summed are looked at four bytes at once
  const uint32_t uncounted = view_.form.shapes + view_.form.planes() - static_cast<uint32_t>(std::popcount(counted));  // shapes are some
  countSymbols<<<dim3(streams, uncounted), kAnsSymbols, 0, stream_>>>(view_, counted << view_.form.shapes);
  WARPSCOPE_CUDA_CHECK_LAUNCH();
  scaleModels<<<models, kAnsSymbols, 0, stream_>>>(histograms_.data(), frequencies_.data(), shares_.data());
  WARPSCOPE_CUDA_CHECK_LAUNCH();
  writeStreams<<<streams, 32, 0, stream_>>>(view_, shares_.data(), words_.data(), wordCounts_.data(), states_.data(), lengths_.data());
  WARPSCOPE_CUDA_CHECK_LAUNCH();
  // Heads first: they say how much is behind, and the host works at them while streams are put together.
  const SheetHeads heads = SheetHeads::of(view_);
  host_.resize(heads.bytes());
  tellHeads<<<1, kSumThreads, 0, stream_>>>(heads, frequencies_.data(), lengths_.data(), offsets_.data(), view_.flags + 1, view_.streams, host_.data());
  WARPSCOPE_CUDA_CHECK_LAUNCH();
  told_.record(stream_);
  gatherStreams<<<streams, 256, 0, stream_>>>(view_, words_.data(), wordCounts_.data(), states_.data(), lengths_.data(), offsets_.data(), packed_.data());
  WARPSCOPE_CUDA_CHECK_LAUNCH();
  gathered_.record(stream_);
}

SummedWords DeviceSheet::append(ByteVector& out) {
  told_.synchronize();
  const SheetHeads heads = SheetHeads::of(view_);
  std::vector<uint32_t> lengths(heads.streams);
  std::memcpy(lengths.data(), host_.data() + heads.lengthsAt(), heads.streams * sizeof(uint32_t));
  std::array<uint32_t, 2> totals;
  std::memcpy(totals.data(), host_.data() + heads.totalsAt(), sizeof totals);
  const auto [packedBytes, layers] = totals;
  std::vector<uint8_t> ofTiles(heads.tiles);
  std::memcpy(ofTiles.data(), host_.data() + heads.tilesAt(), ofTiles.size());
  std::vector<AnsModel> ansModels;
  std::array<uint16_t, kAnsSymbols> frequencies;
  for (uint32_t model = 0; model < view_.form.shapes + layers * view_.form.planes(); ++model) {
    std::memcpy(frequencies.data(), host_.data() + model * sizeof frequencies, sizeof frequencies);
    ansModels.push_back(AnsModel::ofFrequencies(frequencies));
  }
  std::vector<uint32_t> used;
  for (uint32_t tile = 0; tile < view_.tiles(); ++tile)
    for (uint32_t layer = 0; layer < ofTiles[tile]; ++layer) used.push_back(lengths[tile * view_.layers + layer]);
  appendSheetHead(out, layers, ansModels, ofTiles, used);
  const size_t at = out.size();
  SummedWords summed = SummedWords::within(at, packedBytes);
  out.resize(at + packedBytes);
  WARPSCOPE_CUDA_CHECK(cudaMemcpyAsync(out.data() + at, packed_.data(), packedBytes, cudaMemcpyDeviceToHost, stream_));
  gathered_.holdUp(beside_);
  sum_.clear(beside_);
  if (summed.count() > 0) {
    constexpr unsigned kMostBlocks = 512, kThreads = 256;
    sumWords<<<std::min(kMostBlocks, cuda::blocksFor(summed.count(), kThreads)), kThreads, 0, beside_>>>(
        reinterpret_cast<const uint32_t*>(packed_.data()), static_cast<uint32_t>(summed.firstByte() - at), summed, sum_.data());
    WARPSCOPE_CUDA_CHECK_LAUNCH();
  }
  sum_.fetch(beside_);
  WARPSCOPE_CUDA_CHECK(cudaStreamSynchronize(beside_));
  WARPSCOPE_CUDA_CHECK(cudaStreamSynchronize(stream_));
  summed.sum = sum_.onHost();
  return summed;
}

void DeviceSheet::askForReport() {
  const auto fetch = [&](uint32_t& to, const uint32_t* from) { WARPSCOPE_CUDA_CHECK(cudaMemcpyAsync(&to, from, sizeof to, cudaMemcpyDeviceToHost, stream_)); };
  fetch(report_.data()->values, view_.begins + size_t{view_.tiles()} * view_.layers);
  fetch(report_.data()->flags, view_.flags);
}

SheetReport DeviceSheet::report() {
  WARPSCOPE_CUDA_CHECK(cudaStreamSynchronize(stream_));
  return *report_;
}

}  // namespace warpscope
