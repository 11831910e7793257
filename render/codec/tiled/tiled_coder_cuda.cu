// Frames to device memory and back, and the order of kernels.
// See tiled_coder_cuda.h.
#include "render/codec/tiled/tiled_coder_cuda.h"

#include <algorithm>
#include <cstring>

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
constexpr const char* kDamagedTiles = "a tile of the payload is damaged";

class CudaTiledCoder final : public TiledCoder {
 public:
  void appendSamples(std::vector<std::byte>& out, const SampleFrame& frame, Placement placement) override {
    const auto count = static_cast<uint32_t>(frame.size());
    const bool hasLayers = !frame.layers().empty();
    const TileGrid grid = tiledGridOf(frame, count);
    if (grid.count() == 0) return host().appendSamples(out, frame, placement);
    sheet_->begin(grid, sampleForm(hasLayers), hasLayers ? static_cast<uint32_t>(mostTiledLayers(frame)) : 1, true);
    const SheetView view = sheet_->reserveValues(count);
    const SampleView samples = samplesOf(frame, placement, count, hasLayers);
    b_.samples.upload(std::span(frame.samples), stream_);
    b_.colors.upload(std::span(frame.colors), stream_);
    if (hasLayers) b_.layers.upload(frame.layers(), stream_);
    clearHash();
    countSamples<<<cuda::blocksFor(count, kThreads), kThreads, 0, stream_>>>(samples, view, hash_.data());
    WARPSCOPE_CUDA_CHECK_LAUNCH();
    fetchHash();
    sheet_->count();
    sheet_->makeMasks();
    arrangeSamples<<<rowsOfTiles(view), kTileWidth, 0, stream_>>>(samples, view);
    WARPSCOPE_CUDA_CHECK_LAUNCH();
    putFronts(view, samples.jobs(), stream_);
    const size_t hashAt = out.size();
    appendLittle(out, uint64_t{0});
    sheet_->append(out);
    storeLittle(out.data() + hashAt, *hashOnHost_.data());
  }

  DecodeError takeSamples(ByteReader& reader, Placement placement, size_t count, SampleFrame& frame) override {
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
    sheet_->begin(grid, sampleForm(hasLayers), mostLayers, true);
    const SheetView view = sheet_->reserveValues(static_cast<uint32_t>(count));
    if (!sheet_->upload(head_)) return kDamagedTiles;
    const SampleView samples = samplesOf(frame, placement, static_cast<uint32_t>(count), hasLayers);
    sheet_->takeShapes(mostLayers, nullptr);
    sheet_->count();
    sheet_->takePlanes();
    findOriginsOf(samples.paths, view);
    clearHash();
    takeFronts(view, samples.jobs(), stream_);
    finishSamples<<<rowsOfTiles(view), kTileWidth, 0, stream_>>>(samples, view, hash_.data());
    WARPSCOPE_CUDA_CHECK_LAUNCH();
    fetchHash();
    frame.samples = pinned<PackedSample>(count);
    frame.colors = pinned<Rgba8>(count);
    download(frame.samples.data(), b_.samples, count);
    download(frame.colors.data(), b_.colors, count);
    if (hasLayers) {
      plane->values = pinned<std::byte>(count);
      download(reinterpret_cast<uint8_t*>(plane->values.data()), b_.layers, count);
    }
    const uint32_t flags = sheet_->flags();
    if ((flags & kDamagedShapes) != 0) return "the tiles' numbers of samples are damaged";
    if (sheet_->total() != count) return "the tiles of the payload have other numbers of samples than the frame";
    if (flags != 0) return kDamagedTiles;
    if (*hashOnHost_.data() != hash) return kOtherSamples;
    return std::nullopt;
  }

  void appendSegments(std::vector<std::byte>& out, const SampleFrame& frame, Placement placement) override {
    const FrameSegments& segments = frame.segments;
    const auto count = static_cast<uint32_t>(segments.size());
    const bool hasNormals = !segments.normals.empty();
    sheet_->begin({frame.camera.width, frame.camera.height}, segmentForm(hasNormals), static_cast<uint32_t>(frame.settings.sample.segments), false);
    const SheetView view = sheet_->reserveValues(count);
    const SegmentView own = segmentsOf(frame, placement, segments.rays.size(), count, hasNormals);
    b_.rays.upload({reinterpret_cast<const uint8_t*>(segments.rays.data()), segments.rays.size()}, stream_);
    b_.depths.upload(std::span(segments.depths), stream_);
    b_.colors.upload(std::span(segments.colors), stream_);
    if (hasNormals) b_.normals.upload(std::span(segments.normals), stream_);
    hash(own);
    countRays<<<cuda::blocksFor(own.pixels, kThreads), kThreads, 0, stream_>>>(own, view);
    WARPSCOPE_CUDA_CHECK_LAUNCH();
    sheet_->count();
    putRays<<<view.tiles(), kThreads, 0, stream_>>>(own, view);
    WARPSCOPE_CUDA_CHECK_LAUNCH();
    arrangeSegments<<<rowsOfTiles(view), kTileWidth, 0, stream_>>>(own, view);
    WARPSCOPE_CUDA_CHECK_LAUNCH();
    putFronts(view, own.jobs(), stream_);
    const size_t hashAt = out.size();
    appendLittle(out, uint64_t{0});
    sheet_->append(out);
    storeLittle(out.data() + hashAt, *hashOnHost_.data());
  }

  DecodeError takeSegments(ByteReader& reader, Placement placement, bool hasNormals, size_t most, SampleFrame& frame) override {
    FrameSegments& segments = frame.segments;
    const auto hashSent = reader.take<uint64_t>();
    const TileGrid grid{frame.camera.width, frame.camera.height};
    const auto layers = static_cast<uint32_t>(std::clamp(frame.settings.sample.segments, 0, static_cast<int>(kSegmentsRange.highest)));
    if (DecodeError error = head_.take(reader, segmentForm(hasNormals), grid.count(), layers)) return error;
    sheet_->begin(grid, segmentForm(hasNormals), layers, false);
    if (!sheet_->upload(head_)) return kDamagedTiles;
    const size_t pixels = size_t{grid.width} * grid.height;
    b_.rays.reserve(pixels);
    sheet_->takeShapes(layers, b_.rays.data());
    sheet_->count();
    const size_t count = sheet_->total();
    if ((sheet_->flags() & kDamagedShapes) != 0) return "what rays have of segments is damaged";
    if (count > most) return "the frame has more segments than are allowed";
    const SheetView view = sheet_->reserveValues(static_cast<uint32_t>(count));
    const SegmentView own = segmentsOf(frame, placement, pixels, count, hasNormals);
    sheet_->takePlanes();
    findOriginsOf(own.paths, view);
    takeFronts(view, own.jobs(), stream_);
    finishSegments<<<rowsOfTiles(view), kTileWidth, 0, stream_>>>(own, view);
    WARPSCOPE_CUDA_CHECK_LAUNCH();
    hash(own);
    // While the device works: rays are filled with zeros.
    segments.rays = pinned<RaySegmentCount>(pixels);
    segments.depths = pinned<SegmentDepths>(count);
    segments.colors = pinned<Rgba8>(count);
    segments.normals = pinned<NormalCode>(hasNormals ? count : 0);
    download(reinterpret_cast<uint8_t*>(segments.rays.data()), b_.rays, pixels);
    download(segments.depths.data(), b_.depths, count);
    download(segments.colors.data(), b_.colors, count);
    if (hasNormals) download(segments.normals.data(), b_.normals, count);
    if (sheet_->flags() != 0) return "a tile of segments is damaged";
    if (*hashOnHost_.data() != hashSent) return kOtherSegments;
    return std::nullopt;
  }

  void forget() override {
    sheet_ = std::make_unique<DeviceSheet>(stream_);
    b_ = {};
    host_.reset();
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
    if (b_.noise.capacity() == 0) b_.noise.upload(blueNoise(), stream_);
    paths.jitter.noise = b_.noise.data();
    return paths;
  }

  SampleView samplesOf(const SampleFrame& frame, Placement placement, uint32_t count, bool hasLayers) {
    b_.samples.reserve(count);
    b_.colors.reserve(count);
    if (hasLayers) b_.layers.reserve(count);
    reserveStreams(count);
    const RadiusPrediction radius(frame);
    return {pathsOf(frame, placement), sampleRuleOf(frame), pixelEdge(frame.camera), radius.isAsBefore(), count, b_.samples.data(), b_.colors.data(),
            hasLayers ? b_.layers.data() : nullptr, b_.origins.data(), b_.words[0].data(), b_.words[1].data(), b_.words[2].data()};
  }

  SegmentView segmentsOf(const SampleFrame& frame, Placement placement, size_t pixels, size_t count, bool hasNormals) {
    b_.rays.reserve(pixels);
    b_.depths.reserve(count);
    b_.colors.reserve(count);
    if (hasNormals) b_.normals.reserve(count);
    reserveStreams(count);
    return {pathsOf(frame, placement), static_cast<uint32_t>(pixels), static_cast<uint32_t>(count), b_.rays.data(), b_.depths.data(), b_.colors.data(),
            hasNormals ? b_.normals.data() : nullptr, b_.origins.data(), b_.words[0].data(), b_.words[1].data(), b_.words[2].data(), b_.words[3].data()};
  }

  void reserveStreams(size_t values) {
    b_.origins.reserve(values);
    for (cuda::DeviceBuffer<uint32_t>& words : b_.words) words.reserve(values);
  }

  void findOriginsOf(const PathGrid& paths, const SheetView& view) {
    findOrigins<<<rowsOfTiles(view), kTileWidth, 0, stream_>>>(paths, view, b_.origins.data());
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

  struct Buffers {
    cuda::DeviceBuffer<PackedSample> samples;
    cuda::DeviceBuffer<Rgba8> colors;
    cuda::DeviceBuffer<uint8_t> layers, rays;
    cuda::DeviceBuffer<SegmentDepths> depths;
    cuda::DeviceBuffer<NormalCode> normals;
    // In the order of streams.
    cuda::DeviceBuffer<int32_t> origins;
    cuda::DeviceBuffer<uint32_t> words[FrontJobs::kMost];
    cuda::DeviceBuffer<float> noise;
  };

  const cuda::Stream stream_;
  std::unique_ptr<DeviceSheet> sheet_ = std::make_unique<DeviceSheet>(stream_);
  SheetHead head_;
  TiledCoderPtr host_;  // of frames without tiles
  Buffers b_;
  cuda::DeviceBuffer<unsigned long long> hash_{1};
  cuda::PinnedValue<uint64_t> hashOnHost_;
};

}  // namespace

TiledCoderPtr makeCudaTiledCoder() { return std::make_shared<CudaTiledCoder>(); }

}  // namespace warpscope
