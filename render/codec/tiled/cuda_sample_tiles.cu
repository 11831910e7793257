// See cuda_sample_tiles.h.
#include "render/codec/tiled/cuda_sample_tiles.h"

#include "render/codec/plane_coding.h"
#include "render/codec/radius_prediction.h"
#include "render/codec/tiled/sample_kernels.cuh"
#include "render/codec/tiled/tiled_samples.h"

namespace warpscope {
namespace {

/// Also of a frame on a device, whose plane of layers has no values.
bool hasLayers(const SampleFrame& frame) { return std::ranges::any_of(frame.planes, isImplied); }

}  // namespace

bool CudaSampleTiles::takes(const SampleFrame& frame) {
  return tiledGridOf(frame, frame.size()).count() > 0 && mostTiledSampleBytes(frame, frame.size()) <= kMostDeviceBytes;
}

CudaSampleTiles::Memory CudaSampleTiles::roomIn(CudaFrameBuffers& held, size_t count, bool hasLayers) {
  held.samples.reserve(count);
  held.colors.reserve(count);
  if (hasLayers) held.layers.reserve(count);
  return {held.samples.data(), held.colors.data(), hasLayers ? held.layers.data() : nullptr};
}

SampleView CudaSampleTiles::viewOf(const SampleFrame& frame, Placement placement, uint32_t count, const Memory& memory) {
  reserveStreams(count);
  const RadiusPrediction radius(frame);
  return {pathsOf(frame, placement), sampleRuleOf(frame), pixelEdge(frame.camera), radius.isAsBefore(), count, memory.samples, memory.colors,
          memory.layers, origins_.data(), words_[0].data(), words_[1].data(), words_[2].data()};
}

void CudaSampleTiles::beginToAppend(const SampleFrame& frame, Placement placement) {
  const auto count = static_cast<uint32_t>(frame.size());
  const bool isLayered = hasLayers(frame);
  sheet_.begin(tiledGridOf(frame, count), sampleForm(isLayered), isLayered ? static_cast<uint32_t>(mostTiledLayers(frame)) : 1, true);
  sheet_.reserveValues(count);
  const SheetView view = sheet_.clearHistograms();
  const CudaFrame* const there = CudaFrame::ofAway(frame);
  CudaFrameBuffers& held = there != nullptr ? there->buffers() : uploaded_;
  if (there == nullptr) {
    held.samples.upload(std::span(frame.samples), stream_);
    held.colors.upload(std::span(frame.colors), stream_);
    if (isLayered) held.layers.upload(frame.layers(), stream_);
  }
  const SampleView samples = viewOf(frame, placement, count, roomIn(held, count, isLayered));
  hash_.clear(stream_);
  countSamples<<<cuda::blocksFor(count, kThreads), kThreads, 0, stream_>>>(samples, view, hash_.data());
  WARPSCOPE_CUDA_CHECK_LAUNCH();
  hash_.fetch(stream_);
  sheet_.count();
  sheet_.makeMasks();
  arrangeSamples<<<rowsOfTiles(view), kCodedTileWidth, 0, stream_>>>(samples, view);
  WARPSCOPE_CUDA_CHECK_LAUNCH();
  putFronts(view, samples.jobs(), stream_);
  sheet_.write(samples.jobs().planes(view.form));
}

DecodeError CudaSampleTiles::beginToTake(ByteReader& reader, Placement placement, size_t count, const SampleFrame& frame, CudaFrame& held,
                                         DecodedPlace place) {
  const TileGrid grid = tiledGridOf(frame, count);
  hashSent_ = reader.take<uint64_t>();
  if (reader.ranOut()) return "the tiled payload ends before its head does";
  const bool isLayered = hasLayers(frame);
  const auto mostLayers = static_cast<uint32_t>(mostTiledLayers(frame));
  if (DecodeError error = head_.take(reader, sampleForm(isLayered), grid.count(), mostLayers)) return error;
  if (count > size_t{grid.width} * grid.height * mostLayers) return kOtherNumbers;  // what memory is made for depends on the picture, not on who says how many there are
  sheet_.begin(grid, sampleForm(isLayered), mostLayers, true);
  if (!sheet_.upload(head_)) return kDamagedTiles;
  sheet_.takeShapes(std::min(mostLayers, head_.layers), nullptr);
  sheet_.count();
  const SheetView view = sheet_.reserveValues(static_cast<uint32_t>(count));
  const SampleView samples = viewOf(frame, placement, static_cast<uint32_t>(count), roomIn(held.buffers(), count, isLayered));
  sheet_.takePlanes();
  findOrigins<<<rowsOfTiles(view), kCodedTileWidth, 0, stream_>>>(samples.paths, view, origins_.data());
  WARPSCOPE_CUDA_CHECK_LAUNCH();
  hash_.clear(stream_);
  takeFronts(view, samples.jobs(), stream_);
  finishSamples<<<rowsOfTiles(view), kCodedTileWidth, 0, stream_>>>(samples, view, hash_.data());
  WARPSCOPE_CUDA_CHECK_LAUNCH();
  hash_.fetch(stream_);
  sheet_.askForReport();
  count_ = count;
  if (place == DecodedPlace::device) return std::nullopt;
  takenSamples_ = pinned<PackedSample>(count);
  takenColors_ = pinned<Rgba8>(count);
  takenLayers_ = pinned<std::byte>(isLayered ? count : 0);
  download(takenSamples_.data(), samples.samples, count);
  download(takenColors_.data(), samples.colors, count);
  if (isLayered) download(reinterpret_cast<uint8_t*>(takenLayers_.data()), samples.layers, count);
  return std::nullopt;
}

DecodeError CudaSampleTiles::take(SampleFrame& frame, CudaFrame& held) {
  const SheetReport report = sheet_.report();
  if ((report.flags & kDamagedShapes) != 0) return "the tiles' numbers of samples are damaged";
  if (report.values != count_) return kOtherNumbers;
  if ((report.flags & ~static_cast<uint32_t>(kWithoutRadius)) != 0) return kDamagedTiles;
  if (hash_.onHost() != hashSent_) return kOtherSamples;
  frame.samples = std::move(takenSamples_);
  frame.colors = std::move(takenColors_);
  for (SamplePlane& plane : frame.planes)
    if (isImplied(plane)) plane.values = std::move(takenLayers_);
  CudaFrameSizes sizes = held.sizes();
  sizes.samples = count_;
  sizes.hasLayers = hasLayers(frame);
  held.setSizes(sizes);
  held.setHaveRadii((report.flags & kWithoutRadius) == 0);
  return std::nullopt;
}

}  // namespace warpscope
