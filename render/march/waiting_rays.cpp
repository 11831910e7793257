// Merging, and what becomes of what is merged.
// See waiting_rays.h.
#include "render/march/waiting_rays.h"

#include <utility>

#include "render/core/counters.h"
#include "render/march/segment_batch_encoder.h"

namespace warpscope {

void WaitingRays::finish() {
  const int count = std::exchange(count_, 0);
  if (count == 0) return;
  segments_.merge(count);
  const RayLattice* lattices[SegmentBatchMerger::kRays];
  bool anyEnded = false;
  for (int lane = 0; lane < count; ++lane) {
    const MarchedRay& ray = rays_[lane];
    lattices[lane] = &ray.lattice;
    const bool hasEnded = ray.handed == nullptr || ray.handed->isDone;
    anyEnded = anyEnded || hasEnded;
    if (hasEnded)
      WARPSCOPE_COUNT(segmentedRays, 1);
    else
      segments_.give(lane, ray.handedSegments());
  }
  if (!anyEnded) return;
  segments_.finish(job_.mostSegments, lattices);
  // Of rays that were handed on all have the same tile.
  if (rays_[0].handed != nullptr && rays_[0].finished.tile->goesTwice) {
    for (int lane = 0; lane < count; ++lane)
      if (rays_[lane].handed->isDone) segments_.give(lane, rays_[lane].handedSegments());
    return;
  }
  if (job_.normalAt)
    for (int lane = 0; lane < count; ++lane)
      for (int i = 0; i < segments_.size(lane); ++i) rays_[lane].segments.normals[i] = job_.normalAt(rays_[lane], placeToLight(segments_.segment(lane, i)));
  if (job_.rule != nullptr) encode(count);
  for (int lane = 0; lane < count; ++lane) {
    MarchedRay& ray = rays_[lane];
    if (ray.handed != nullptr && !ray.handed->isDone) continue;
    if (job_.rule == nullptr) list(lane);
    job_.onMerged(ray);
  }
}

void WaitingRays::encode(int count) {
  float cosines[SegmentBatchMerger::kRays];
  const NormalCode* normals[SegmentBatchMerger::kRays];
  EncodedSegments* encoded[SegmentBatchMerger::kRays];
  for (int lane = 0; lane < count; ++lane) {
    MarchedRay& ray = rays_[lane];
    cosines[lane] = ray.finished.cosine;
    normals[lane] = ray.segments.normals;
    encoded[lane] = &ray.encoded;
    ray.finished.encoded = &ray.encoded;
  }
  encodeSegments(segments_, count, cosines, job_.rule->quantization, job_.normalAt ? normals : nullptr, encoded);
}

void WaitingRays::list(int lane) {
  MarchedRay& ray = rays_[lane];
  SegmentList& list = ray.segments.list;
  list.clear();
  for (int i = 0; i < segments_.size(lane); ++i) list.add(segments_.segment(lane, i));
  ray.finished.segments = &list;
}

}  // namespace warpscope
