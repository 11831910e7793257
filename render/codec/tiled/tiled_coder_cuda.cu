// Frames to device memory and back, and the order of kernels.
// See tiled_coder_cuda.h.
#include "render/codec/tiled/tiled_coder_cuda.h"

#include <algorithm>
#include <semaphore>

#include "render/base/shared_pool.h"
#include "render/codec/plane_coding.h"
#include "render/codec/radius_prediction.h"
#include "render/codec/tiled/sample_kernels.cuh"
#include "render/codec/tiled/segment_kernels.cuh"
#include "render/codec/tiled/tile_fronts.h"
#include "render/codec/tiled/tiled_samples.h"
#include "render/codec/tiled/tiled_segments.h"
#include "render/cuda/memory.h"
#include "render/cuda/pinned_memory.h"

namespace warpscope {
namespace {

constexpr unsigned kThreads = 256;
constexpr uint64_t kMostBytes = ~uint32_t{0};  // of streams: a device counts them in 32 bits
constexpr const char* kDamagedTiles = "a tile of the payload is damaged";

/// What works at one frame at a time, with buffers in device memory.
class CudaTiles {
 public:
  void appendSamples(std::vector<std::byte>& out, const SampleFrame& frame, Placement placement) {
    const auto count = static_cast<uint32_t>(frame.size());
    const bool hasLayers = !frame.layers().empty();
    const TileGrid grid = tiledGridOf(frame, count);
    if (grid.count() == 0 || mostTiledSampleBytes(frame, count) > kMostBytes) return host().appendSamples(out, frame, placement);
    sheet_.begin(grid, sampleForm(hasLayers), hasLayers ? static_cast<uint32_t>(mostTiledLayers(frame)) : 1, true);
    const SheetView view = sheet_.reserveValues(count);
    const SampleView samples = samplesOf(frame, placement, count, hasLayers);
    samples_.upload(std::span(frame.samples), stream_);
    colors_.upload(std::span(frame.colors), stream_);
    if (hasLayers) layers_.upload(frame.layers(), stream_);
    clearHash();
    countSamples<<<cuda::blocksFor(count, kThreads), kThreads, 0, stream_>>>(samples, view, hash_.data());
    WARPSCOPE_CUDA_CHECK_LAUNCH();
    fetchHash();
    sheet_.count();
    sheet_.makeMasks();
    arrangeSamples<<<rowsOfTiles(view), kCodedTileWidth, 0, stream_>>>(samples, view);
    WARPSCOPE_CUDA_CHECK_LAUNCH();
    putFronts(view, samples.jobs(), stream_);
    const size_t hashAt = out.size();
    appendLittle(out, uint64_t{0});
    sheet_.append(out);
    storeLittle(out.data() + hashAt, *hashOnHost_.data());
  }

  DecodeError takeSamples(ByteReader& reader, Placement placement, size_t count, SampleFrame& frame) {
    const TileGrid grid = tiledGridOf(frame, count);
    if (grid.count() == 0) return host().takeSamples(reader, placement, count, frame);
    const auto hash = reader.take<uint64_t>();
    if (reader.ranOut()) return "the tiled payload ends before its head does";
    SamplePlane* plane = nullptr;
    for (SamplePlane& each : frame.planes)
      if (isImplied(each)) plane = &each;
    const bool hasLayers = plane != nullptr;
    const auto mostLayers = static_cast<uint32_t>(mostTiledLayers(frame));
    if (DecodeError error = head_.take(reader, sampleForm(hasLayers), grid.count(), mostLayers)) return error;
    sheet_.begin(grid, sampleForm(hasLayers), mostLayers, true);
    if (!sheet_.upload(head_)) return kDamagedTiles;
    sheet_.takeShapes(std::min(mostLayers, head_.layers), nullptr);
    sheet_.count();
    const size_t total = sheet_.total();
    if ((sheet_.flags() & kDamagedShapes) != 0) return "the tiles' numbers of samples are damaged";
    if (total != count) return "the tiles of the payload have other numbers of samples than the frame";
    const SheetView view = sheet_.reserveValues(static_cast<uint32_t>(count));
    const SampleView samples = samplesOf(frame, placement, static_cast<uint32_t>(count), hasLayers);
    sheet_.takePlanes();
    findOriginsOf(samples.paths, view);
    clearHash();
    takeFronts(view, samples.jobs(), stream_);
    finishSamples<<<rowsOfTiles(view), kCodedTileWidth, 0, stream_>>>(samples, view, hash_.data());
    WARPSCOPE_CUDA_CHECK_LAUNCH();
    fetchHash();
    frame.samples = pinned<PackedSample>(count);
    frame.colors = pinned<Rgba8>(count);
    download(frame.samples.data(), samples_, count);
    download(frame.colors.data(), colors_, count);
    if (hasLayers) {
      plane->values = pinned<std::byte>(count);
      download(reinterpret_cast<uint8_t*>(plane->values.data()), layers_, count);
    }
    if (sheet_.flags() != 0) return kDamagedTiles;
    if (*hashOnHost_.data() != hash) return kOtherSamples;
    return std::nullopt;
  }

  void appendSegments(std::vector<std::byte>& out, const SampleFrame& frame, Placement placement) {
    const FrameSegments& segments = frame.segments;
    if (segments.empty() || mostTiledSegmentBytes(frame.camera, static_cast<uint64_t>(frame.settings.sample.segments)) > kMostBytes)
      return host().appendSegments(out, frame, placement);
    const auto count = static_cast<uint32_t>(segments.size());
    const bool hasNormals = !segments.normals.empty();
    sheet_.begin({frame.camera.width, frame.camera.height}, segmentForm(hasNormals), static_cast<uint32_t>(frame.settings.sample.segments), false);
    const SheetView view = sheet_.reserveValues(count);
    const SegmentView own = segmentsOf(frame, placement, segments.rays.size(), count, hasNormals);
    rays_.upload({reinterpret_cast<const uint8_t*>(segments.rays.data()), segments.rays.size()}, stream_);
    depths_.upload(std::span(segments.depths), stream_);
    colors_.upload(std::span(segments.colors), stream_);
    if (hasNormals) normals_.upload(std::span(segments.normals), stream_);
    hash(own);
    countRays<<<cuda::blocksFor(own.pixels, kThreads), kThreads, 0, stream_>>>(own, view);
    WARPSCOPE_CUDA_CHECK_LAUNCH();
    sheet_.count();
    putRays<<<view.tiles(), kThreads, 0, stream_>>>(own, view);
    WARPSCOPE_CUDA_CHECK_LAUNCH();
    arrangeSegments<<<rowsOfTiles(view), kCodedTileWidth, 0, stream_>>>(own, view);
    WARPSCOPE_CUDA_CHECK_LAUNCH();
    putFronts(view, own.jobs(), stream_);
    const size_t hashAt = out.size();
    appendLittle(out, uint64_t{0});
    sheet_.append(out);
    storeLittle(out.data() + hashAt, *hashOnHost_.data());
  }

  DecodeError takeSegments(ByteReader& reader, Placement placement, bool hasNormals, size_t most, SampleFrame& frame) {
    FrameSegments& segments = frame.segments;
    const auto hashSent = reader.take<uint64_t>();
    const TileGrid grid{frame.camera.width, frame.camera.height};
    const auto layers = static_cast<uint32_t>(std::clamp(frame.settings.sample.segments, 0, static_cast<int>(kSegmentsRange.highest)));
    if (DecodeError error = head_.take(reader, segmentForm(hasNormals), grid.count(), layers)) return error;
    sheet_.begin(grid, segmentForm(hasNormals), layers, false);
    if (!sheet_.upload(head_)) return kDamagedTiles;
    const size_t pixels = size_t{grid.width} * grid.height;
    rays_.reserve(pixels);
    sheet_.takeShapes(std::min(layers, head_.layers), rays_.data());
    sheet_.count();
    const size_t count = sheet_.total();
    if ((sheet_.flags() & kDamagedShapes) != 0) return "what rays have of segments is damaged";
    if (count > most) return "the frame has more segments than are allowed";
    const SheetView view = sheet_.reserveValues(static_cast<uint32_t>(count));
    const SegmentView own = segmentsOf(frame, placement, pixels, count, hasNormals);
    sheet_.takePlanes();
    findOriginsOf(own.paths, view);
    takeFronts(view, own.jobs(), stream_);
    finishSegments<<<rowsOfTiles(view), kCodedTileWidth, 0, stream_>>>(own, view);
    WARPSCOPE_CUDA_CHECK_LAUNCH();
    hash(own);
    // While the device works: rays are filled with zeros.
    segments.rays = pinned<RaySegmentCount>(pixels);
    segments.depths = pinned<SegmentDepths>(count);
    segments.colors = pinned<Rgba8>(count);
    segments.normals = pinned<NormalCode>(hasNormals ? count : 0);
    download(reinterpret_cast<uint8_t*>(segments.rays.data()), rays_, pixels);
    download(segments.depths.data(), depths_, count);
    download(segments.colors.data(), colors_, count);
    if (hasNormals) download(segments.normals.data(), normals_, count);
    if (sheet_.flags() != 0) return "a tile of segments is damaged";
    if (*hashOnHost_.data() != hashSent) return kOtherSegments;
    return std::nullopt;
  }

 private:
  TiledCoder& host() {
    if (!host_) host_ = makeHostTiledCoder();
    return *host_;
  }

  template <class T>
  static TransferVector<T> pinned(size_t count) {
    return TransferVector<T>(count, TransferAllocator<T>(cuda::pinnedMemory()));
  }
  template <class T>
  void download(T* to, const cuda::DeviceBuffer<T>& from, size_t count) {
    if (count > 0) WARPSCOPE_CUDA_CHECK(cudaMemcpyAsync(to, from.data(), count * sizeof(T), cudaMemcpyDeviceToHost, stream_));
  }

  /// What rays of the frame share, with the device's noise.
  PathGrid pathsOf(const SampleFrame& frame, Placement placement) {
    PathGrid paths = pathGridOf(frame, placement);
    if (paths.jitter.noise == nullptr) return paths;
    if (noise_.capacity() == 0) noise_.upload(blueNoise(), stream_);
    paths.jitter.noise = noise_.data();
    return paths;
  }

  SampleView samplesOf(const SampleFrame& frame, Placement placement, uint32_t count, bool hasLayers) {
    samples_.reserve(count);
    colors_.reserve(count);
    if (hasLayers) layers_.reserve(count);
    reserveStreams(count);
    const RadiusPrediction radius(frame);
    return {pathsOf(frame, placement), sampleRuleOf(frame), pixelEdge(frame.camera), radius.isAsBefore(), count, samples_.data(), colors_.data(),
            hasLayers ? layers_.data() : nullptr, origins_.data(), words_[0].data(), words_[1].data(), words_[2].data()};
  }

  SegmentView segmentsOf(const SampleFrame& frame, Placement placement, size_t pixels, size_t count, bool hasNormals) {
    rays_.reserve(pixels);
    depths_.reserve(count);
    colors_.reserve(count);
    if (hasNormals) normals_.reserve(count);
    reserveStreams(count);
    return {pathsOf(frame, placement), static_cast<uint32_t>(pixels), static_cast<uint32_t>(count), rays_.data(), depths_.data(), colors_.data(),
            hasNormals ? normals_.data() : nullptr, origins_.data(), words_[0].data(), words_[1].data(), words_[2].data(), words_[3].data()};
  }

  void reserveStreams(size_t values) {
    origins_.reserve(values);
    for (cuda::DeviceBuffer<uint32_t>& words : words_) words.reserve(values);
  }

  void findOriginsOf(const PathGrid& paths, const SheetView& view) {
    findOrigins<<<rowsOfTiles(view), kCodedTileWidth, 0, stream_>>>(paths, view, origins_.data());
    WARPSCOPE_CUDA_CHECK_LAUNCH();
  }

  void clearHash() { WARPSCOPE_CUDA_CHECK(cudaMemsetAsync(hash_.data(), 0, sizeof(unsigned long long), stream_)); }
  /// To hashOnHost_, when the stream has got there.
  void fetchHash() { WARPSCOPE_CUDA_CHECK(cudaMemcpyAsync(hashOnHost_.data(), hash_.data(), sizeof(uint64_t), cudaMemcpyDeviceToHost, stream_)); }
  void hash(const SegmentView& own) {
    clearHash();
    hashSegments<<<cuda::blocksFor(std::max(own.pixels, own.count), kThreads), kThreads, 0, stream_>>>(own, hash_.data());
    WARPSCOPE_CUDA_CHECK_LAUNCH();
    fetchHash();
  }

  const cuda::Stream stream_;
  DeviceSheet sheet_{stream_};
  SheetHead head_;
  TiledCoderPtr host_;  // of frames without tiles
  cuda::DeviceBuffer<PackedSample> samples_;
  cuda::DeviceBuffer<Rgba8> colors_;
  cuda::DeviceBuffer<uint8_t> layers_, rays_;
  cuda::DeviceBuffer<SegmentDepths> depths_;
  cuda::DeviceBuffer<NormalCode> normals_;
  // In the order of streams.
  cuda::DeviceBuffer<int32_t> origins_;
  cuda::DeviceBuffer<uint32_t> words_[FrontJobs::kMost];
  cuda::DeviceBuffer<float> noise_;
  cuda::DeviceBuffer<unsigned long long> hash_{1};
  cuda::PinnedValue<uint64_t> hashOnHost_;
};

using CudaTilesPool = SharedPool<CudaTiles>;

/// One of few workers, which whoever asks waits for: a frame keeps half of a device busy, as few workers keep their device memory, and threads that wait leave their core to
/// others, which those that wait for a device do not.
class CudaWorker {
 public:
  explicit CudaWorker(const std::shared_ptr<CudaTilesPool>& workers) : tiles_(workers->take()) {}
  CudaTiles* operator->() const { return &*tiles_; }

 private:
  struct Place {
    Place() { all().acquire(); }
    ~Place() { all().release(); }
    Place(const Place&) = delete;
    Place& operator=(const Place&) = delete;

    static std::counting_semaphore<>& all() {
      static std::counting_semaphore<> places(kMostAtOnce);
      return places;
    }
  };
  static constexpr int kMostAtOnce = 4;

  const Place place_;  // taken before and left behind what follows
  const CudaTilesPool::Lease tiles_;
};

class CudaTiledCoder final : public TiledCoder {
 public:
  CudaTiledCoder() { workers_->take(); }  // fails here if it does

  void appendSamples(std::vector<std::byte>& out, const SampleFrame& frame, Placement placement) override { CudaWorker(workers_)->appendSamples(out, frame, placement); }
  DecodeError takeSamples(ByteReader& reader, Placement placement, size_t count, SampleFrame& frame) override {
    return CudaWorker(workers_)->takeSamples(reader, placement, count, frame);
  }
  void appendSegments(std::vector<std::byte>& out, const SampleFrame& frame, Placement placement) override { CudaWorker(workers_)->appendSegments(out, frame, placement); }
  DecodeError takeSegments(ByteReader& reader, Placement placement, bool hasNormals, size_t most, SampleFrame& frame) override {
    return CudaWorker(workers_)->takeSegments(reader, placement, hasNormals, most, frame);
  }
  void forget() override { workers_->forget(); }

 private:
  const std::shared_ptr<CudaTilesPool> workers_ = CudaTilesPool::ofProcess();
};

}  // namespace

TiledCoderPtr makeCudaTiledCoder() { return std::make_shared<CudaTiledCoder>(); }

}  // namespace warpscope
