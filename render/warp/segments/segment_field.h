// A frame's segments as another camera's rays meet them: the frustum of each of the frame's pixels, cut by planes of equal forward depth.
// Plain data for host and device; segment_walk.h goes through it, segment_field_build.h makes it.
#pragma once

#include <cstdint>
#include <limits>

#include "render/core/pixel_grid.h"

namespace warpscope {

/// Where a segment of a pixel lies, and how dense it is: what walks look for; its colour lies elsewhere. One load on a device. Forward depths behind the
/// frame's near plane, volume units.
struct alignas(16) FieldSegment {
  float begin = 0.0f, end = 0.0f;  ///< begin < end
  float extinction = 0.0f;         ///< optical depth by length, along any line
};

/// What lies in a square of pixels, so that it can be leapt over. Depths as in FieldSegment.
struct alignas(16) FieldTile {
  float nearestBegin = std::numeric_limits<float>::infinity();
  float farthestEnd = -std::numeric_limits<float>::infinity();
  float nearestUnknown = std::numeric_limits<float>::infinity();  ///< depth from which on something is not known
  float farthestUnknown = -std::numeric_limits<float>::infinity();  ///< depth from which on nothing is

  WARPSCOPE_HD void include(const FieldTile& other) {
    nearestBegin = minOf(nearestBegin, other.nearestBegin);
    farthestEnd = maxOf(farthestEnd, other.farthestEnd);
    nearestUnknown = minOf(nearestUnknown, other.nearestUnknown);
    farthestUnknown = maxOf(farthestUnknown, other.farthestUnknown);
  }
};

/// Edges of tiles, in cells, as powers of two; the first are the smallest.
inline constexpr int kFieldLevels = 2;
WARPSCOPE_HD constexpr int fieldShift(int level) { return 3 * (level + 1); }

/// All of them, by pointers to where they are.
///
/// Between the centres of four pixels beside each other is a cell; cells outside of the outermost centres are half as wide. Cell (0, 0) lies between the
/// picture's corner and the first pixel's centre.
struct SegmentField {
  PixelGrid pixels;  ///< of the frame's camera
  int width = 0, height = 0;
  const uint32_t* first = nullptr;         ///< for each pixel and one more, where its segments begin; kEndedBit is set where the ray before it ended
  const FieldSegment* segments = nullptr;
  const glm::vec3* colors = nullptr;  ///< of the segments: linear, of what is opaque: emission is this times the extinction
  const FieldTile* tiles[kFieldLevels] = {};
  int tileColumns[kFieldLevels] = {};

  static constexpr uint32_t kEndedBit = 1u << 31;
};

}  // namespace warpscope
