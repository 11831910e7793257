// A frame's segments as another camera's rays meet them: the frustum of each of the frame's pixels, cut by planes of equal forward depth.
// Plain data for host and device; segment_walk.h and nearest_walk.h go through it, segment_field_build.h makes it.
#pragma once

#include <cstdint>
#include <limits>

#include "render/core/numeric.h"
#include "render/core/pixel_grid.h"

namespace warpscope {

/// Depths in which lines in space go straight along their lines in the picture, as window depths do: affine in 1 / forward depth. Counted so that neither an eye
/// far away nor one inside of what is seen costs bits: around a forward depth that is not nearer than the near plane nor than an eighth of what is seen is long.
struct PictureDepths {
  float nearDepth = 0.0f;  ///< forward depth of the near plane
  float reference = 1.0f;  ///< forward depth whose picture depth is 0; at least nearDepth, more than 0

  /// Least forward depth from the eye that has one. Where the eye is inside of what is seen, half a step between codes (quantizationFor()): what begins at the eye begins there.
  WARPSCOPE_HD float leastFromEye() const { return nearDepth > 0.0f ? nearDepth * 0.5f : reference * 0x1p-16f; }
  /// Of a forward depth behind the near plane (volume units), at least leastFromEye() - nearDepth; grows with it.
  WARPSCOPE_HD float of(float behind) const { return reference * (behind + (nearDepth - reference)) / (nearDepth + behind); }
  /// How far two depths are apart, in forward depth: of the rounded numbers, so that what is thin is not wrong by their rounding. `beginBehind`, `endBehind`: what they
  /// are of().
  WARPSCOPE_HD float between(float begin, float end, float beginBehind, float endBehind) const {
    return (end - begin) * ((nearDepth + beginBehind) / reference) * ((nearDepth + endBehind) / reference);
  }
};

/// Where a segment of a pixel lies. One load on a device.
struct alignas(8) FieldSpan {
  float begin = 0.0f, end = 0.0f;  ///< picture depths, begin < end
};

/// What it is of. One load on a device.
struct alignas(16) FieldMatter {
  glm::vec3 color{0.0f};    ///< linear, of what is opaque: emission is this times the extinction
  float extinction = 0.0f;  ///< optical depth by length, along any line
};

/// Where there are segments in a square of pixels, so that it can be leapt over. Picture depths. One load on a device.
struct alignas(8) FieldTileSpan {
  float nearestBegin = std::numeric_limits<float>::infinity();
  float farthestEnd = -std::numeric_limits<float>::infinity();
};

/// And what is known there.
struct alignas(16) FieldTile : FieldTileSpan {
  float nearestUnknown = std::numeric_limits<float>::infinity();    ///< from which on something is not known
  float farthestUnknown = -std::numeric_limits<float>::infinity();  ///< from which on nothing is

  WARPSCOPE_HD void include(const FieldTile& other) {
    nearestBegin = minOf(nearestBegin, other.nearestBegin);
    farthestEnd = maxOf(farthestEnd, other.farthestEnd);
    nearestUnknown = minOf(nearestUnknown, other.nearestUnknown);
    farthestUnknown = maxOf(farthestUnknown, other.farthestUnknown);
  }
};

/// Edges of tiles, in cells, as powers of two; the first are single cells.
inline constexpr int kFieldLevels = 4;
inline constexpr int kFieldLevelShift = 2;
WARPSCOPE_HD constexpr int fieldShift(int level) { return kFieldLevelShift * level; }

/// All of them, by pointers to where they are.
///
/// Between the centres of four pixels beside each other is a cell; cells outside of the outermost centres are half as wide. Cell (0, 0) lies between the
/// picture's corner and the first pixel's centre.
struct SegmentField {
  PixelGrid pixels;  ///< of the frame's camera
  PictureDepths depths;
  int width = 0, height = 0;
  const uint32_t* first = nullptr;         ///< for each pixel and one more, where its segments begin; kEndedBit is set where the ray before it ended
  const FieldSpan* spans = nullptr;      ///< of the segments; and as many more as may be read (kBeyond), whatever they are
  const FieldMatter* matter = nullptr;   ///< of the segments; at least one
  const float* places = nullptr;         ///< where the segments are lit: forward depth behind the near plane
  const FieldTile* tiles[kFieldLevels] = {};
  int tileColumns[kFieldLevels] = {};

  static constexpr uint32_t kEndedBit = 1u << 31;
  static constexpr size_t kBeyond = 3;  // walks look at four at once
};

}  // namespace warpscope
