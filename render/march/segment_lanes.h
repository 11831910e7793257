// Segments of as many rays as vectors have lanes, a ray a lane.
// xsimd; host only.
#pragma once

#include "render/core/simd.h"
#include "render/march/ray_segments.h"

namespace warpscope {

/// A segment of each ray. As RaySegment.
struct SegmentLanes {
  FloatBatch begin, end, opacity, through, color[3];

  FloatBatch contribution() const { return through * opacity; }
  FloatBatch length() const { return end - begin; }
};

/// The numbers of a SegmentLanes in memory.
struct SegmentRow {
  alignas(64) float begin[kBatchLanes], end[kBatchLanes], opacity[kBatchLanes], through[kBatchLanes], color[3][kBatchLanes];

  RaySegment segment(int lane) const { return {begin[lane], end[lane], opacity[lane], through[lane], {color[0][lane], color[1][lane], color[2][lane]}}; }
  SegmentLanes lanes() const {
    const auto loaded = [](const float* numbers) { return FloatBatch::load_aligned(numbers); };
    return {loaded(begin), loaded(end), loaded(opacity), loaded(through), {loaded(color[0]), loaded(color[1]), loaded(color[2])}};
  }
  void set(const SegmentLanes& segments) {
    segments.begin.store_aligned(begin);
    segments.end.store_aligned(end);
    segments.opacity.store_aligned(opacity);
    segments.through.store_aligned(through);
    for (int channel = 0; channel < 3; ++channel) segments.color[channel].store_aligned(color[channel]);
  }
};

inline SegmentLanes selected(const xsimd::batch_bool<float>& condition, const SegmentLanes& a, const SegmentLanes& b) {
  const auto either = [&](const FloatBatch& ofA, const FloatBatch& ofB) { return xsimd::select(condition, ofA, ofB); };
  return {either(a.begin, b.begin), either(a.end, b.end), either(a.opacity, b.opacity), either(a.through, b.through),
          {either(a.color[0], b.color[0]), either(a.color[1], b.color[1]), either(a.color[2], b.color[2])}};
}

}  // namespace warpscope
