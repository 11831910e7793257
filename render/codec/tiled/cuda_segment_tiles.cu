// See cuda_segment_tiles.h.
#include "render/codec/tiled/cuda_segment_tiles.h"

#include <algorithm>

#include "render/codec/segment_coding.h"
#include "render/codec/tiled/segment_kernels.cuh"
#include "render/codec/tiled/tiled_segments.h"

namespace warpscope {

bool CudaSegmentTiles::takes(const SampleFrame& frame) {
  const CudaFrame* const there = CudaFrame::ofAway(frame);
  const bool isEmpty = there != nullptr ? there->sizes().rays == 0 : frame.segments.empty();
  const uint64_t count = there != nullptr ? there->sizes().segments : frame.segments.size();
  return !isEmpty && mostTiledSegmentBytes(frame.camera, count, static_cast<uint64_t>(frame.settings.sample.segments)) <= kMostDeviceBytes;
}

CudaSegmentTiles::Memory CudaSegmentTiles::roomIn(CudaFrameBuffers& held, size_t pixels, size_t count, bool hasNormals) {
  held.rays.reserve(pixels);
  held.depths.reserve(count);
  held.segmentColors.reserve(count);
  if (hasNormals) held.normals.reserve(count);
  return {reinterpret_cast<uint8_t*>(held.rays.data()), held.depths.data(), held.segmentColors.data(), hasNormals ? held.normals.data() : nullptr};
}

SegmentView CudaSegmentTiles::viewOf(const SampleFrame& frame, Placement placement, size_t pixels, size_t count, const Memory& memory) {
  reserveStreams(count);
  return {pathsOf(frame, placement), static_cast<uint32_t>(pixels), static_cast<uint32_t>(count), memory.rays, memory.depths, memory.colors,
          memory.normals, origins_.data(), words_[0].data(), words_[1].data(), words_[2].data(), words_[3].data()};
}

void CudaSegmentTiles::hash(const SegmentView& segments, cudaStream_t stream) {
  hash_.clear(stream);
  constexpr unsigned kMostBlocks = 1024;  // each ends with additions to one word, which wait for one another
  hashSegments<<<std::min(kMostBlocks, cuda::blocksFor(std::max(segments.pixels, segments.count), kThreads)), kThreads, 0, stream>>>(segments, hash_.data());
  WARPSCOPE_CUDA_CHECK_LAUNCH();
  hash_.fetch(stream);
}

void CudaSegmentTiles::beginToAppend(const SampleFrame& frame, Placement placement) {
  const size_t pixels = size_t{frame.camera.width} * frame.camera.height;
  const CudaFrame* const there = CudaFrame::ofAway(frame);
  CudaFrameBuffers& held = there != nullptr ? there->buffers() : uploaded_;
  const FrameSegments& segments = frame.segments;
  const size_t count = there != nullptr ? there->sizes().segments : segments.size();
  const bool hasNormals = there != nullptr ? there->sizes().hasNormals : !segments.normals.empty();
  if (there == nullptr) {
    held.rays.upload(std::span(segments.rays), stream_);
    held.depths.upload(std::span(segments.depths), stream_);
    held.segmentColors.upload(std::span(segments.colors), stream_);
    held.normals.upload(std::span(segments.normals), stream_);
  }
  sheet_.begin({frame.camera.width, frame.camera.height}, segmentForm(hasNormals), static_cast<uint32_t>(frame.settings.sample.segments), false);
  sheet_.reserveValues(static_cast<uint32_t>(count));
  const SheetView view = sheet_.clearHistograms();
  const SegmentView own = viewOf(frame, placement, pixels, count, roomIn(held, pixels, count, hasNormals));
  countRays<<<cuda::blocksFor(own.pixels, kThreads), kThreads, 0, stream_>>>(own, view);
  WARPSCOPE_CUDA_CHECK_LAUNCH();
  sheet_.count();
  putRays<<<view.tiles(), kThreads, 0, stream_>>>(own, view);
  WARPSCOPE_CUDA_CHECK_LAUNCH();
  arrangeSegments<<<rowsOfTiles(view), kCodedTileWidth, 0, stream_>>>(own, view);
  WARPSCOPE_CUDA_CHECK_LAUNCH();
  putFronts(view, own.jobs(), stream_);
  sheet_.write(own.jobs().planes(view.form));
  hash(own, there != nullptr ? beside_ : stream_);  // what was uploaded is in the stream's order
}

DecodeError CudaSegmentTiles::beginToTake(ByteReader& reader, Placement placement, bool hasNormals, size_t most, const SampleFrame& frame, CudaFrame& held,
                                          DecodedPlace place) {
  const TileGrid grid{frame.camera.width, frame.camera.height};
  taken_ = {placement, hasNormals, most, reader.take<uint64_t>(), place, size_t{grid.width} * grid.height, 0, {}};
  const auto layers = static_cast<uint32_t>(std::clamp(frame.settings.sample.segments, 0, static_cast<int>(kSegmentsRange.highest)));
  if (DecodeError error = head_.take(reader, segmentForm(hasNormals), grid.count(), layers)) return error;
  sheet_.begin(grid, segmentForm(hasNormals), layers, false);
  if (!sheet_.upload(head_)) return kDamagedTiles;
  sheet_.takeShapes(std::min(layers, head_.layers), roomIn(held.buffers(), taken_.pixels, 0, hasNormals).rays);
  sheet_.count();
  sheet_.askForReport();
  return std::nullopt;
}

DecodeError CudaSegmentTiles::goOnTaking(const SampleFrame& frame, CudaFrame& held) {
  const bool hasNormals = taken_.hasNormals;
  const size_t pixels = taken_.pixels;
  const SheetReport report = sheet_.report();
  const size_t count = report.values;
  if ((report.flags & kDamagedShapes) != 0) return "what rays have of segments is damaged";
  if (count > taken_.most) return "the frame has more segments than are allowed";
  taken_.count = count;
  const SheetView view = sheet_.reserveValues(static_cast<uint32_t>(count));
  const SegmentView own = viewOf(frame, taken_.placement, pixels, count, roomIn(held.buffers(), pixels, count, hasNormals));
  sheet_.takePlanes();
  findOrigins<<<rowsOfTiles(view), kCodedTileWidth, 0, stream_>>>(own.paths, view, origins_.data());
  WARPSCOPE_CUDA_CHECK_LAUNCH();
  takeFronts(view, own.jobs(), stream_);
  finishSegments<<<rowsOfTiles(view), kCodedTileWidth, 0, stream_>>>(own, view);
  WARPSCOPE_CUDA_CHECK_LAUNCH();
  hash(own, stream_);
  sheet_.askForReport();
  if (taken_.place == DecodedPlace::device) return std::nullopt;
  // While the device works: rays are filled with zeros.
  FrameSegments& segments = taken_.segments;
  segments.rays = pinned<RaySegmentCount>(pixels);
  segments.depths = pinned<SegmentDepths>(count);
  segments.colors = pinned<Rgba8>(count);
  segments.normals = pinned<NormalCode>(hasNormals ? count : 0);
  download(reinterpret_cast<uint8_t*>(segments.rays.data()), own.rays, pixels);
  download(segments.depths.data(), own.depths, count);
  download(segments.colors.data(), own.colors, count);
  if (hasNormals) download(segments.normals.data(), own.normals, count);
  return std::nullopt;
}

DecodeError CudaSegmentTiles::take(SampleFrame& frame, CudaFrame& held) {
  const uint32_t flags = sheet_.report().flags;
  if ((flags & ~kDisordered) != 0) return "a tile of segments is damaged";
  if (hash_.onHost() != taken_.hashSent) return kOtherSegments;
  if (flags != 0) return kDisorderedSegments;
  frame.segments = std::move(taken_.segments);
  CudaFrameSizes sizes = held.sizes();
  sizes.rays = taken_.pixels;
  sizes.segments = taken_.count;
  sizes.hasNormals = taken_.hasNormals;
  held.setSizes(sizes);
  return std::nullopt;
}

}  // namespace warpscope
