// From a frame's codes to what a field has of them, one at a time: for host and device.
// The opacity of a segment of homogeneous matter is 1 - exp(-optical depth) (Beer, Lambert).
#pragma once

#include <cmath>

#include "render/march/frame_segments.h"
#include "render/warp/segments/segment_field.h"

namespace warpscope {

/// For each code of a segment's opacity. Computed by the host, whose logarithm a device's is not.
struct OpticalDepths {
  float of[256];
};
inline OpticalDepths opticalDepths() {
  OpticalDepths depths;
  for (uint32_t code = 0; code < 256; ++code) depths.of[code] = -std::log1p(-minOf(segmentOpacity(code << 24), kMostSegmentOpacity));
  return depths;
}

/// What a frame's camera and codes say of where its segments lie.
struct FieldDepths {
  PictureDepths picture;
  float step = 1.0f;  ///< forward depth between two codes; the shortest that a segment may be
};
inline FieldDepths fieldDepthsOf(const SampleQuantization& quantization) {
  const float span = decodeDepth(1u << 18, quantization.depthStep);  // about: quantizationFor()
  return {{quantization.nearDepth, maxOf(quantization.nearDepth, span * 0x1p-3f)}, quantization.depthStep};
}

/// What a field has of a segment, but for its colour.
struct FieldSegment {
  FieldSpan span;
  float extinction = 0.0f, place = 0.0f;
};

/// Makes segments of one pixel's codes, near to far.
class FieldSegmentsOfPixel {
 public:
  /// `cosine` of the pixel's ray.
  WARPSCOPE_HD FieldSegmentsOfPixel(const FieldDepths& depths, const OpticalDepths& opticalDepths, float cosine)
      : depths_(depths), opticalDepths_(opticalDepths), cosine_(cosine), last_(maxOf(depths.picture.leastFromEye() - depths.picture.nearDepth, 0.0f)) {}

  WARPSCOPE_HD FieldSegment next(const SegmentDepths& codes, Rgba8 color) {
    const float begin = maxOf(decodeDepth(codes.begin, depths_.step), last_);
    last_ = maxOf(decodeDepth(codes.end, depths_.step), begin + depths_.step);
    FieldSegment segment;
    segment.span = {depths_.picture.of(begin), depths_.picture.of(last_)};
    segment.extinction = opticalDepths_.of[color >> 24] * cosine_ / depths_.picture.between(segment.span.begin, segment.span.end, begin, last_);
    segment.place = mulAdd(placeOfHalf(minOf(segmentOpacity(color), kMostSegmentOpacity)), last_ - begin, begin);
    return segment;
  }

 private:
  const FieldDepths& depths_;
  const OpticalDepths& opticalDepths_;
  float cosine_;
  float last_;  // where the one before ends; of the first, where there may be something at all
};

/// Of a pixel whose segments' spans these are, near to far.
WARPSCOPE_HD inline FieldTile tileOf(const FieldSpan* spans, uint32_t count, bool isEnded) {
  FieldTile tile;
  if (count > 0) {
    tile.nearestBegin = spans[0].begin;
    tile.farthestEnd = spans[count - 1].end;
  }
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  tile.nearestUnknown = tile.farthestUnknown = !isEnded ? kInfinity : count > 0 ? tile.farthestEnd : -kInfinity;
  return tile;
}

/// How many tiles of a level there are along an axis with so many pixels.
WARPSCOPE_HD constexpr int tilesAlong(int pixels, int level) { return (pixels >> fieldShift(level)) + 1; }

/// A level of tiles and the parts that it has, along both axes: pixels, or tiles of the level before.
struct TileLevel {
  int columns, rows, partColumns, partRows;

  size_t count() const { return static_cast<size_t>(columns) * static_cast<size_t>(rows); }
};
inline TileLevel tileLevel(int width, int height, int level) {
  return {tilesAlong(width, level), tilesAlong(height, level), level == 0 ? width : tilesAlong(width, level - 1), level == 0 ? height : tilesAlong(height, level - 1)};
}

/// By pointers into arrays of the host or of a device.
template <class Firsts, class Spans, class Matter, class Places, class Tiles>
SegmentField fieldOf(const PixelGrid& pixels, const PictureDepths& depths, int width, int height, const Firsts& first, const Spans& spans, const Matter& matter,
                     const Places& places, const Tiles (&tiles)[kFieldLevels]) {
  SegmentField field{.pixels = pixels, .depths = depths, .width = width, .height = height, .first = first.data(), .spans = spans.data(), .matter = matter.data(), .places = places.data()};
  for (int level = 0; level < kFieldLevels; ++level) {
    field.tiles[level] = tiles[level].data();
    field.tileColumns[level] = tilesAlong(width, level);
  }
  return field;
}

/// The tile (column, row) of a level of the parts it has: of pixels, or of tiles of the level before. Cell (x, y) is between pixels x - 1 and x, y - 1 and
/// y; about a pixel's centre, where cells are that, it is the pixel (x, y): both are in.
WARPSCOPE_HD inline FieldTile tileOf(const FieldTile* parts, int partColumns, int partRows, int level, int column, int row) {
  const int edge = level == 0 ? 1 << fieldShift(0) : 1 << (fieldShift(level) - fieldShift(level - 1)), before = level == 0 ? 1 : 0;
  FieldTile all;
  for (int y = maxOf(row * edge - before, 0); y < minOf((row + 1) * edge, partRows); ++y)
    for (int x = maxOf(column * edge - before, 0); x < minOf((column + 1) * edge, partColumns); ++x) all.include(parts[y * partColumns + x]);
  return all;
}

}  // namespace warpscope
