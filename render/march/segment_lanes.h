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
  static constexpr int kNumbers = 7;

  alignas(64) float of[kNumbers][kBatchLanes] = {};

  RaySegment segment(int lane) const { return {of[0][lane], of[1][lane], of[2][lane], of[3][lane], {of[4][lane], of[5][lane], of[6][lane]}}; }
  void setSegment(int lane, const RaySegment& segment) {
    const float numbers[kNumbers] = {segment.begin, segment.end, segment.opacity, segment.through, segment.color.x, segment.color.y, segment.color.z};
    for (int i = 0; i < kNumbers; ++i) of[i][lane] = numbers[i];
  }
  FloatBatch lanes(int i) const { return FloatBatch::load_aligned(of[i]); }
  SegmentLanes lanes() const { return {lanes(0), lanes(1), lanes(2), lanes(3), {lanes(4), lanes(5), lanes(6)}}; }
  void set(const SegmentLanes& segments);
};

/// Calls `f(i, number)` for all numbers, in the order of a row.
template <class Segments, class F>
[[gnu::always_inline]] inline void forEachNumber(Segments& segments, const F& f) {
  f(0, segments.begin);
  f(1, segments.end);
  f(2, segments.opacity);
  f(3, segments.through);
  for (int channel = 0; channel < 3; ++channel) f(4 + channel, segments.color[channel]);
}

inline SegmentLanes selected(const xsimd::batch_bool<float>& condition, const SegmentLanes& a, const SegmentLanes& b) {
  const auto either = [&](const FloatBatch& ofA, const FloatBatch& ofB) { return xsimd::select(condition, ofA, ofB); };
  return {either(a.begin, b.begin), either(a.end, b.end), either(a.opacity, b.opacity), either(a.through, b.through),
          {either(a.color[0], b.color[0]), either(a.color[1], b.color[1]), either(a.color[2], b.color[2])}};
}

inline void SegmentRow::set(const SegmentLanes& segments) {
  forEachNumber(segments, [&](int i, const FloatBatch& number) { number.store_aligned(of[i]); });
}

}  // namespace warpscope
