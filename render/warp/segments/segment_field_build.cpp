// Offsets, extinctions, tiles.
// See segment_field_build.h.
#include "render/warp/segments/segment_field_build.h"

#include <cmath>

#include "render/core/parallel.h"
#include "render/effects/relight.h"
#include "render/effects/shading_setup.h"
#include "render/march/march_setup.h"

namespace warpscope {
namespace {

constexpr size_t kRowsAtOnce = 16;

/// The lights of a frame's scene as a camera has them. Those of the world are where the copy of the volume says; without it the volume's axes are the world's.
ShadingSetup lightsOf(const SampleFrame& frame, const Camera& camera) {
  const Effects& effects = frame.settings.render.effects;
  return prepareLights(effects.shading, effects.lights, frame.proxy ? frame.proxy->volume->geometry() : VolumeGeometry{}, camera);
}

/// Calls f(segment, place) for all of them, in parallel; places in volume space.
template <class F>
void forEachSegment(const SampleFrame& frame, const F& f) {
  const FrameSegments& segments = frame.segments;
  const PixelGrid pixels = makePixelGrid(frame.camera, frame.quantization.nearDepth);
  const float step = frame.quantization.depthStep;
  const uint32_t width = frame.camera.width;
  std::vector<size_t> begins(frame.camera.height + 1, 0);
  for (size_t y = 0; y < frame.camera.height; ++y) {
    begins[y + 1] = begins[y];
    for (size_t x = 0; x < width; ++x) begins[y + 1] += static_cast<size_t>(segments.rays[y * width + x].count());
  }
  parallelForRanges(frame.camera.height, kRowsAtOnce, [&](size_t beginRow, size_t endRow) {
    for (size_t y = beginRow; y < endRow; ++y) {
      size_t at = begins[y];
      for (uint32_t x = 0; x < width; ++x)
        for (int i = 0; i < segments.rays[y * width + x].count(); ++i, ++at) {
          const SegmentDepths& depths = segments.depths[at];
          const float begin = decodeDepth(depths.begin, step), end = decodeDepth(depths.end, step);
          const float opacity = segmentOpacity(segments.colors[at]);
          f(at, pixels.at(x, static_cast<uint32_t>(y), mulAdd(placeOfHalf(opacity), end - begin, begin)));
        }
    }
  });
}

}  // namespace

void BuiltSegmentField::relight(const SampleFrame& frame, const Camera& camera) {
  if (unlit_.empty()) return;
  const ShadingSetup lights = lightsOf(frame, camera);
  forEachSegment(frame, [&](size_t i, const glm::vec3& place) {
    const NormalCode normal = frame.segments.normals[i];
    if (normal == 0) return;
    segments_[i].color = glm::max(relit(factorsOf(lights, normal, glm::normalize(camera.eye - place), place), unlit_[i]), glm::vec3(0.0f));
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
    const ShadingSetup lights = lightsOf(frame, frame.camera);
    forEachSegment(frame, [&](size_t i, const glm::vec3& place) {
      const NormalCode normal = segments.normals[i];
      if (normal != 0) unlit_[i] = unlit(factorsOf(lights, normal, glm::normalize(frame.camera.eye - place), place), segments_[i].color);
    });
  }
  // Cell (x, y) is between pixels x - 1 and x, y - 1 and y; about a pixel's centre, where cells are that, it is the pixel (x, y): both are in.
  for (int level = 0; level < kFieldLevels; ++level) {
    const int shift = kFieldShift[level], edge = 1 << shift;
    const int columns = (width_ >> shift) + 1, rows = (height_ >> shift) + 1;
    tileColumns_[level] = columns;
    tiles_[level].resize(static_cast<size_t>(columns) * static_cast<size_t>(rows));
    parallelForRanges(static_cast<size_t>(rows), 1, [&](size_t beginRow, size_t endRow) {
      for (size_t row = beginRow; row < endRow; ++row)
        for (int column = 0; column < columns; ++column) {
          FieldTile all;
          const int y0 = maxOf((static_cast<int>(row) << shift) - 1, 0), y1 = minOf((static_cast<int>(row) << shift) + edge, height_);
          const int x0 = maxOf((column << shift) - 1, 0), x1 = minOf((column << shift) + edge, width_);
          for (int y = y0; y < y1; ++y)
            for (int x = x0; x < x1; ++x) all.include(ofPixels_[static_cast<size_t>(y) * width + static_cast<size_t>(x)]);
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
