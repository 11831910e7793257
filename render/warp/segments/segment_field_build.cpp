// Offsets, extinctions, tiles.
// See segment_field_build.h.
#include "render/warp/segments/segment_field_build.h"

#include <cmath>

#include "render/core/parallel.h"
#include "render/effects/shading_setup.h"
#include "render/warp/segments/segment_light.h"

namespace warpscope {
namespace {

constexpr size_t kRowsAtOnce = 16;

}  // namespace

ShadingSetup BuiltSegmentField::lightsFor(const SampleFrame& frame, const Camera& camera) {
  const Effects& effects = frame.settings.render.effects;
  return prepareLights(effects.shading, effects.lights, frame.proxy ? frame.proxy->volume->geometry() : VolumeGeometry{}, camera);
}

/// Calls f(segment, its number, column, row) for all that have a normal, in parallel.
template <class F>
void BuiltSegmentField::forEachLit(const SampleFrame& frame, const F& f) {
  const auto width = static_cast<size_t>(width_);
  parallelForRanges(static_cast<size_t>(height_), kRowsAtOnce, [&](size_t beginRow, size_t endRow) {
    for (size_t y = beginRow; y < endRow; ++y)
      for (size_t x = 0; x < width; ++x) {
        const size_t pixel = y * width + x;
        for (uint32_t i = first_[pixel] & ~SegmentField::kEndedBit; i < (first_[pixel + 1] & ~SegmentField::kEndedBit); ++i)
          if (frame.segments.normals[i] != 0) f(segments_[i], i, static_cast<uint32_t>(x), static_cast<uint32_t>(y));
      }
  });
}

void BuiltSegmentField::relight(const SampleFrame& frame, const Camera& camera) {
  if (unlit_.empty()) return;
  const ShadingSetup lights = lightsFor(frame, camera);
  forEachLit(frame, [&](FieldSegment& segment, size_t i, uint32_t x, uint32_t y) {
    segment.color = relitColor(lightOf(segment, frame.segments.normals[i], pixels_, x, y, lights, camera.eye), unlit_[i]);
  });
}

void BuiltSegmentField::build(const SampleFrame& frame) {
  const FrameSegments& segments = frame.segments;
  if (segments.empty()) {
    width_ = height_ = 0;
    return;
  }
  width_ = static_cast<int>(frame.camera.width);
  height_ = static_cast<int>(frame.camera.height);
  pixels_ = makePixelGrid(frame.camera, frame.quantization.nearDepth);
  const size_t pixels = segments.rays.size();
  first_.resize(pixels + 1);
  segments_.resize(segments.size());
  ofPixels_.resize(pixels);
  uint32_t at = 0;
  first_[0] = 0;
  for (size_t i = 0; i < pixels; ++i) {
    at += static_cast<uint32_t>(segments.rays[i].count());
    first_[i + 1] = at | (segments.rays[i].isEnded() ? SegmentField::kEndedBit : 0);
  }
  const ColorTables& tables = ColorTables::instance();
  const float step = frame.quantization.depthStep;
  const auto width = static_cast<size_t>(width_);
  parallelForRanges(static_cast<size_t>(height_), kRowsAtOnce, [&](size_t beginRow, size_t endRow) {
    for (size_t y = beginRow; y < endRow; ++y)
      for (size_t x = 0; x < width; ++x) {
        const size_t pixel = y * width + x;
        const uint32_t begin = first_[pixel] & ~SegmentField::kEndedBit, end = first_[pixel + 1] & ~SegmentField::kEndedBit;
        const bool isEnded = (first_[pixel + 1] & SegmentField::kEndedBit) != 0;
        FieldTile& tile = ofPixels_[pixel];
        tile = {};
        if (begin < end) {
          const float cosine = pixels_.ray(static_cast<uint32_t>(x), static_cast<uint32_t>(y)).cosine;
          for (uint32_t i = begin; i < end; ++i) {
            const SegmentDepths& depths = segments.depths[i];
            const glm::vec4 color = segmentColor(tables, segments.colors[i]);
            FieldSegment& out = segments_[i];
            out.begin = decodeDepth(depths.begin, step);
            out.end = decodeDepth(depths.end > depths.begin ? depths.end : depths.begin + 1, step);
            out.extinction = -std::log1p(-minOf(color.a, kMostSegmentOpacity)) * cosine / (out.end - out.begin);
            out.color = color.a > 0.0f ? glm::vec3(color) / color.a : glm::vec3(0.0f);
          }
          tile.nearestBegin = segments_[begin].begin;
          tile.farthestEnd = segments_[end - 1].end;
        }
        const float unknown = isEnded ? (begin < end ? tile.farthestEnd : 0.0f) : std::numeric_limits<float>::infinity();
        tile.nearestUnknown = tile.farthestUnknown = unknown;
      }
  });
  unlit_.clear();
  if (!segments.normals.empty()) {
    unlit_.resize(segments.size());
    const ShadingSetup lights = lightsFor(frame, frame.camera);
    forEachLit(frame, [&](FieldSegment& segment, size_t i, uint32_t x, uint32_t y) {
      unlit_[i] = warpscope::unlit(lightOf(segment, segments.normals[i], pixels_, x, y, lights, frame.camera.eye), segment.color);
    });
  }
  // Cell (x, y) is between pixels x - 1 and x, y - 1 and y; about a pixel's centre, where cells are that, it is the pixel (x, y): both are in.
  for (int level = 0; level < kFieldLevels; ++level) {
    // Of pixels, or of the level's before, which have all pixels of theirs.
    const bool isOfPixels = level == 0;
    const std::vector<FieldTile>& parts = isOfPixels ? ofPixels_ : tiles_[level - 1];
    const int partColumns = isOfPixels ? width_ : tileColumns_[level - 1], partRows = static_cast<int>(parts.size()) / partColumns;
    const int shift = fieldShift(level), edge = 1 << (isOfPixels ? shift : shift - fieldShift(level - 1)), before = isOfPixels ? 1 : 0;
    const int columns = (width_ >> shift) + 1, rows = (height_ >> shift) + 1;
    tileColumns_[level] = columns;
    tiles_[level].resize(static_cast<size_t>(columns) * static_cast<size_t>(rows));
    parallelForRanges(static_cast<size_t>(rows), 1, [&](size_t beginRow, size_t endRow) {
      for (size_t row = beginRow; row < endRow; ++row)
        for (int column = 0; column < columns; ++column) {
          FieldTile all;
          const int firstY = static_cast<int>(row) * edge, firstX = column * edge;
          for (int y = maxOf(firstY - before, 0); y < minOf(firstY + edge, partRows); ++y)
            for (int x = maxOf(firstX - before, 0); x < minOf(firstX + edge, partColumns); ++x)
              all.include(parts[static_cast<size_t>(y) * static_cast<size_t>(partColumns) + static_cast<size_t>(x)]);
          tiles_[level][row * static_cast<size_t>(columns) + static_cast<size_t>(column)] = all;
        }
    });
  }
}

SegmentField BuiltSegmentField::field() const {
  SegmentField field;
  field.pixels = pixels_;
  field.width = width_;
  field.height = height_;
  field.first = first_.data();
  field.segments = segments_.data();
  for (int level = 0; level < kFieldLevels; ++level) {
    field.tiles[level] = tiles_[level].data();
    field.tileColumns[level] = tileColumns_[level];
  }
  return field;
}

}  // namespace warpscope
