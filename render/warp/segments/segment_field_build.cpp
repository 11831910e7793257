// Offsets, extinctions, tiles.
// See segment_field_build.h.
#include "render/warp/segments/segment_field_build.h"

#include <span>

#include "render/core/parallel.h"
#include "render/effects/shading_setup.h"
#include "render/warp/segments/segment_field_parts.h"
#include "render/warp/segments/segment_light.h"

namespace warpscope {
namespace {

constexpr size_t kRowsAtOnce = 16;

}  // namespace

ShadingSetup segmentLightsFor(const SampleFrame& frame, const Camera& camera) {
  const Effects& effects = frame.settings.render.effects;
  return prepareLights(effects.shading, effects.lights, frame.geometry, camera);
}

/// Calls f(its number, column, row) for all that have a normal, in parallel.
template <class F>
void BuiltSegmentField::forEachLit(const SampleFrame& frame, const F& f) {
  const auto width = static_cast<size_t>(width_);
  parallelForRanges(static_cast<size_t>(height_), kRowsAtOnce, [&](size_t beginRow, size_t endRow) {
    for (size_t y = beginRow; y < endRow; ++y)
      for (size_t x = 0; x < width; ++x) {
        const size_t pixel = y * width + x;
        for (uint32_t i = first_[pixel] & ~SegmentField::kEndedBit; i < (first_[pixel + 1] & ~SegmentField::kEndedBit); ++i)
          if (frame.segments.normals[i] != 0) f(i, static_cast<uint32_t>(x), static_cast<uint32_t>(y));
      }
  });
}

void BuiltSegmentField::relight(const SampleFrame& frame, const Camera& camera) {
  if (unlit_.empty()) return;
  const ShadingSetup lights = segmentLightsFor(frame, camera);
  forEachLit(frame, [&](size_t i, uint32_t x, uint32_t y) {
    matter_[i].color = relitColor(lightOf(places_[i], frame.segments.normals[i], pixels_, x, y, lights, camera.eye), unlit_[i]);
  });
}

void BuiltSegmentField::build(const SampleFrame& frame) {
  const FrameSegments& segments = frame.segments;
  width_ = height_ = 0;
  unlit_.clear();
  if (segments.empty()) return;
  width_ = static_cast<int>(frame.camera.width);
  height_ = static_cast<int>(frame.camera.height);
  pixels_ = makePixelGrid(frame.camera, frame.quantization.nearDepth);
  const size_t pixels = segments.rays.size();
  first_.resize(pixels + 1);
  spans_.resize(segments.size() + SegmentField::kBeyond);
  matter_.resize(segments.size() + 1);  // walks look at one, whether there are any or not
  places_.resize(segments.size());
  ofPixels_.resize(pixels);
  uint32_t at = 0;
  first_[0] = 0;
  for (size_t i = 0; i < pixels; ++i) {
    at += static_cast<uint32_t>(segments.rays[i].count());
    first_[i + 1] = at | (segments.rays[i].isEnded() ? SegmentField::kEndedBit : 0);
  }
  const ColorTables& tables = ColorTables::instance();
  static const OpticalDepths kDepths = opticalDepths();
  const FieldDepths depths = fieldDepthsOf(frame.quantization);
  depths_ = depths.picture;
  const float scale = segmentColorScale(!segments.normals.empty());
  const auto width = static_cast<size_t>(width_);
  parallelForRanges(static_cast<size_t>(height_), kRowsAtOnce, [&](size_t beginRow, size_t endRow) {
    for (size_t y = beginRow; y < endRow; ++y)
      for (size_t x = 0; x < width; ++x) {
        const size_t pixel = y * width + x;
        const uint32_t begin = first_[pixel] & ~SegmentField::kEndedBit, end = first_[pixel + 1] & ~SegmentField::kEndedBit;
        const float cosine = begin < end ? pixels_.ray(static_cast<uint32_t>(x), static_cast<uint32_t>(y)).cosine : 1.0f;
        FieldSegmentsOfPixel ofPixel(depths, kDepths, cosine);
        for (uint32_t i = begin; i < end; ++i) {
          const FieldSegment segment = ofPixel.next(segments.depths[i], segments.colors[i]);
          spans_[i] = segment.span;
          matter_[i] = {straightSegmentColor(tables, segments.colors[i], scale), segment.extinction};
          places_[i] = segment.place;
        }
        ofPixels_[pixel] = tileOf(spans_.data() + begin, end - begin, (first_[pixel + 1] & SegmentField::kEndedBit) != 0);
      }
  });
  if (!segments.normals.empty()) {
    unlit_.resize(segments.size());
    const ShadingSetup lights = segmentLightsFor(frame, frame.camera);
    forEachLit(frame, [&](size_t i, uint32_t x, uint32_t y) {
      unlit_[i] = warpscope::unlit(lightOf(places_[i], segments.normals[i], pixels_, x, y, lights, frame.camera.eye), matter_[i].color);
    });
  }
  size_t tiles = 0;
  for (int level = 0; level < kFieldLevels; ++level) tiles += tileLevel(width_, height_, level).count();
  tiles_.resize(tiles);
  const FieldTile* parts = ofPixels_.data();
  FieldTile* own = tiles_.data();
  for (int level = 0; level < kFieldLevels; ++level) {
    const TileLevel size = tileLevel(width_, height_, level);
    parallelForRanges(static_cast<size_t>(size.rows), 1, [&](size_t beginRow, size_t endRow) {
      for (size_t row = beginRow; row < endRow; ++row)
        for (int column = 0; column < size.columns; ++column)
          own[row * static_cast<size_t>(size.columns) + static_cast<size_t>(column)] = tileOf(parts, size.partColumns, size.partRows, level, column, static_cast<int>(row));
    });
    parts = own;
    own += size.count();
  }
}

SegmentField BuiltSegmentField::field() const {
  std::span<const FieldTile> levels[kFieldLevels], rest = tiles_;
  for (int level = 0; level < kFieldLevels && !rest.empty(); ++level) {
    levels[level] = rest.first(tileLevel(width_, height_, level).count());
    rest = rest.subspan(levels[level].size());
  }
  return fieldOf(pixels_, depths_, width_, height_, first_, spans_, matter_, places_, levels);
}

}  // namespace warpscope
