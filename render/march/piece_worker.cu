// Packing rays side by side, and telling their tiles what they have met.
// See piece_worker.h.
#include "render/march/piece_worker.h"

#include <algorithm>
#include <cstddef>
#include <span>

namespace warpscope {
namespace {

/// Rays that are packed side by side are those of such a block of pixels, as far as they are still under way: they go the same way.
constexpr uint32_t kBlockWidth = 8, kBlockHeight = 4;
/// Samples that count, of the rays of a launch, where a heuristic wants them listed: of more the CPU marches the tiles. 32 MiB of each thread's.
constexpr uint32_t kListedRoom = 1u << 20;

/// Calls `f(x, y, place)` for the pixels of a tile, those beside each other one after the other.
template <class F>
void forEachPixel(const PixelArea& area, const F& f) {
  for (uint32_t row = 0; row < area.height; row += kBlockHeight)
    for (uint32_t column = 0; column < area.width; column += kBlockWidth)
      for (uint32_t y = row; y < std::min(row + kBlockHeight, area.height); ++y)
        for (uint32_t x = column; x < std::min(column + kBlockWidth, area.width); ++x) f(area.x + x, area.y + y, y * area.width + x);
}

}  // namespace

bool PieceWorker::marchFirst(const PieceFrame& frame, Tiles& tiles, const PieceLaunches& launches) {
  pack(frame, tiles);
  if (rays_.empty()) return true;
  PieceRays job;
  job.count = static_cast<uint32_t>(rays_.size());
  deviceRays_.upload(rays_, stream_);
  deviceMet_.upload(met_, stream_);
  deviceResults_.reserve(rays_.size());
  deviceLeft_.reserve(rays_.size());
  clearCounts();
  job.rays = deviceRays_.data();
  job.met = deviceMet_.data();
  job.results = deviceResults_.data();
  job.left = deviceLeft_.data();
  job.leftCount = &deviceCounts_.data()->left;
  const bool hasSegments = frame.mostSegments > 0;
  if (hasSegments) {
    deviceMetSegments_.upload(metSegments_, stream_);
    deviceLeftSegments_.reserve(rays_.size());
    job.metSegments = deviceMetSegments_.data();
    job.leftSegments = deviceLeftSegments_.data();
  }
  if (frame.listsSamples) {
    deviceListed_.reserve(kListedRoom);
    job.listed = deviceListed_.data();
    job.listedRoom = kListedRoom;
    job.listedCount = &deviceCounts_.data()->listed;
  }
  launches.first(job, stream_);
  fetch(deviceResults_, results_, rays_.size(), PieceResult{});
  fetchCounts();
  const Counts counts = *counts_;
  if (counts.listed > kListedRoom) return false;
  fetch(deviceListed_, listed_, counts.listed, ListedSample{});
  fetch(deviceLeft_, left_, counts.left, RelayedState{});
  if (hasSegments) fetch(deviceLeftSegments_, leftSegments_, counts.left, SegmentMerger(mergerRoomFor(frame.mostSegments)));
  stream_.synchronize();
  for (const ListedSample& one : std::span(listed_).first(counts.listed)) places_[one.ray].tile->rays[places_[one.ray].ray].counting.push_back(one.sample);
  unpack(frame);
  return true;
}

void PieceWorker::pack(const PieceFrame& frame, Tiles& tiles) {
  rays_.clear(), met_.clear(), metSegments_.clear(), places_.clear();
  for (const std::unique_ptr<RelayedTile>& tile : tiles) {
    if (tile->segments.empty() && frame.mostSegments > 0) tile->segments.assign(tile->rays.size(), SegmentMerger(mergerRoomFor(frame.mostSegments)));
    tile->isDivided = frame.mostParts > 1;
    tile->goesTwice = tile->isDivided || frame.hasNormals;
    forEachPixel(tile->area, [&](uint32_t x, uint32_t y, uint32_t place) { packRay(*tile, place, {x, y, -1, tile->isLast}); });
  }
}

void PieceWorker::packRay(RelayedTile& tile, uint32_t place, PieceRay ray) {
  const RelayedRay& handed = tile.rays[place];
  if (handed.isDone) return;
  if (handed.state.hasMet()) {
    ray.met = static_cast<int32_t>(met_.size());
    met_.push_back(handed.state);
    if (!tile.segments.empty()) metSegments_.push_back(tile.segments[place]);
  }
  rays_.push_back(ray);
  places_.push_back({&tile, place});
}

void PieceWorker::unpack(const PieceFrame& frame) {
  for (size_t i = 0; i < rays_.size(); ++i) {
    const auto& [tile, place] = places_[i];
    const PieceResult& result = results_[i];
    RelayedRay& handed = tile->rays[place];
    handed.isDone = result.isDone;
    if (result.met < 0) continue;
    handed.state = left_[static_cast<size_t>(result.met)];
    if (frame.mostSegments > 0) tile->segments[place].take(leftSegments_[static_cast<size_t>(result.met)]);
    if (handed.isDone && !tile->goesTwice) finish(frame, *tile, place);
  }
}

bool PieceWorker::marchAgain(const PieceFrame& frame, Tiles& tiles, const PieceLaunches& launches) {
  packAgain(frame, tiles);
  if (!parted_.empty()) {
    PartedRays job;
    job.count = static_cast<uint32_t>(parted_.size());
    job.mostParts = frame.mostParts;
    deviceParted_.upload(parted_, stream_);
    deviceListed_.reserve(kListedRoom);
    deviceClosed_.reserve(parted_.size() * static_cast<size_t>(frame.mostParts));
    clearCounts();
    job.rays = deviceParted_.data();
    job.listed = deviceListed_.data();
    job.listedRoom = kListedRoom;
    job.listedCount = &deviceCounts_.data()->listed;
    job.closed = deviceClosed_.data();
    job.closedCount = &deviceCounts_.data()->closed;
    launches.again(job, stream_);
  }
  if (!lit_.empty()) {
    deviceLit_.upload(lit_, stream_);
    deviceNormals_.reserve(lit_.size());
    launches.normals(deviceLit_.data(), static_cast<uint32_t>(lit_.size()), deviceNormals_.data(), stream_);
    fetch(deviceNormals_, normals_, lit_.size(), NormalCode{0});
  }
  Counts counts;
  if (!parted_.empty()) {
    fetchCounts();
    counts = *counts_;
    if (counts.listed > kListedRoom) return false;
    fetch(deviceParted_, parted_, parted_.size(), parted_.front());
    fetch(deviceListed_, listed_, counts.listed, ListedSample{});
    fetch(deviceClosed_, closed_, counts.closed, ClosedPart{});
  }
  stream_.synchronize();
  unpackAgain(frame, tiles, counts.listed, counts.closed);
  return true;
}

void PieceWorker::packAgain(const PieceFrame& frame, Tiles& tiles) {
  parted_.clear(), lit_.clear(), normalPlaces_.clear(), places_.clear();
  for (const std::unique_ptr<RelayedTile>& tile : tiles)
    forEachPixel(tile->area, [&](uint32_t x, uint32_t y, uint32_t place) {
      const RelayedRay& handed = tile->rays[place];
      if (handed.isDone) return;
      if (const RelayedAgain& again = tile->again[place]; again.isDivided) {
        parted_.push_back({x, y, handed.state.next, again.accumulatedEnd, again.part});
        places_.push_back({tile.get(), place});
      }
      if (!frame.hasNormals) return;
      const SegmentMerger& segments = tile->segments[place];
      for (int i = segments.first(); i != SegmentMerger::kNone; i = segments.behind(i)) {
        const float t = placeToLight(segments[i]);
        if (!isWithin(frame.relay.block(), frame.view, frame.pixels.ray(x, y).ray, t)) continue;
        lit_.push_back({x, y, t});
        normalPlaces_.push_back({{tile.get(), place}, i});
      }
    });
}

void PieceWorker::unpackAgain(const PieceFrame& frame, Tiles& tiles, size_t listed, size_t closed) {
  // Of each ray the parts that have ended, near to far, and how many of them have been told.
  struct Closed {
    glm::vec4 colors[kMaxRaySamples];
    uint32_t count = 0, told = 0;
  };
  std::vector<Closed> closedOf(parted_.size());
  for (const ClosedPart& part : std::span(closed_).first(closed)) closedOf[part.ray].colors[closedOf[part.ray].count++] = part.color;
  const auto closePart = [&](const Place& at, const glm::vec4& color) {
    RelayedRay& handed = at.tile->rays[at.ray];
    at.tile->again[at.ray].found.add({frame.depthOfSamples(handed.counting), color});
    handed.counting.clear();
  };
  const auto tellUntil = [&](uint32_t ray, uint32_t count) {
    while (closedOf[ray].told < count) closePart(places_[ray], closedOf[ray].colors[closedOf[ray].told++]);
  };
  for (const ListedSample& one : std::span(listed_).first(listed)) {
    tellUntil(one.ray, one.closed);
    places_[one.ray].tile->rays[places_[one.ray].ray].counting.push_back(one.sample);
  }
  for (uint32_t i = 0; i < parted_.size(); ++i) {
    tellUntil(i, closedOf[i].count);
    const auto& [tile, place] = places_[i];
    tile->again[place].part = parted_[i].part;
    tile->rays[place].state.next = parted_[i].next;
  }
  for (size_t i = 0; i < normalPlaces_.size(); ++i) {
    const auto& [at, segment] = normalPlaces_[i];
    at.tile->again[at.ray].normals[segment] = normals_[i];
  }
  for (const std::unique_ptr<RelayedTile>& tile : tiles) {
    if (!tile->isLast) continue;
    for (uint32_t place = 0; place < tile->rays.size(); ++place) {
      RelayedRay& handed = tile->rays[place];
      if (handed.isDone) continue;
      handed.isDone = true;
      if (const RelayedAgain& again = tile->again[place]; again.isDivided && again.part.any) closePart({tile.get(), place}, again.part.piece.premultiplied());
      finish(frame, *tile, place);
    }
  }
}

void PieceWorker::finish(const PieceFrame& frame, RelayedTile& tile, uint32_t place) {
  const RelayedRay& handed = tile.rays[place];
  const RelayedAgain* const again = tile.isAgain ? &tile.again[place] : nullptr;
  FinishedRay finished{tile.area.x + place % tile.area.width, tile.area.y + place / tile.area.width};
  finished.tile = &tile;
  finished.cosine = frame.pixels.ray(finished.x, finished.y).cosine;
  finished.premultiplied = handed.state.color.premultiplied();
  finished.isEnded = handed.state.color.transmittance.value() < frame.limits.stopBelow;
  if (frame.mostSegments > 0) segments_.take(tile.segments[place], again != nullptr && frame.hasNormals ? again->normals : nullptr, finished);
  if (again != nullptr && again->isDivided) {
    finished.samples = &again->found;
  } else {
    if (frame.sample != nullptr) findSampleOf(handed, frame.depthOfSamples, frame.sample->heuristic, finished.premultiplied, found_);
    finished.samples = &found_;
  }
  tile.keep(finished, frame.sample, frame.hasNormals, frame.rule, frame.pixels);
}

void PieceWorker::clearCounts() { WARPSCOPE_CUDA_CHECK(cudaMemsetAsync(deviceCounts_.data(), 0, sizeof(Counts), stream_)); }

void PieceWorker::fetchCounts() {
  WARPSCOPE_CUDA_CHECK(cudaMemcpyAsync(counts_.data(), deviceCounts_.data(), sizeof(Counts), cudaMemcpyDeviceToHost, stream_));
  stream_.synchronize();
}

}  // namespace warpscope
