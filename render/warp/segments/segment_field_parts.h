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

/// `cosine` of the pixel's ray; `step`: of the frame's depth codes.
WARPSCOPE_HD inline FieldSegment fieldSegmentOf(const SegmentDepths& codes, Rgba8 color, const OpticalDepths& depths, float step, float cosine) {
  FieldSegment segment;
  segment.begin = decodeDepth(codes.begin, step);
  segment.end = decodeDepth(codes.end > codes.begin ? codes.end : codes.begin + 1, step);
  segment.extinction = depths.of[color >> 24] * cosine / (segment.end - segment.begin);
  return segment;
}

WARPSCOPE_HD inline glm::vec3 fieldColorOf(const ColorTables& tables, Rgba8 code) {
  const glm::vec4 color = segmentColor(tables, code);
  return color.w > 0.0f ? glm::vec3(color) / color.w : glm::vec3(0.0f);
}

/// Of a pixel whose segments these are, near to far.
WARPSCOPE_HD inline FieldTile tileOf(const FieldSegment* segments, uint32_t count, bool isEnded) {
  FieldTile tile;
  if (count > 0) {
    tile.nearestBegin = segments[0].begin;
    tile.farthestEnd = segments[count - 1].end;
  }
  tile.nearestUnknown = tile.farthestUnknown = isEnded ? (count > 0 ? tile.farthestEnd : 0.0f) : std::numeric_limits<float>::infinity();
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
template <class Firsts, class Segments, class Colors, class Tiles>
SegmentField fieldOf(const PixelGrid& pixels, int width, int height, const Firsts& first, const Segments& segments, const Colors& colors,
                     const Tiles (&tiles)[kFieldLevels]) {
  SegmentField field{.pixels = pixels, .width = width, .height = height, .first = first.data(), .segments = segments.data(), .colors = colors.data()};
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
