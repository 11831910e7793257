// The segments of a frame's rays: what a pixel says of its ray beside one depth. After the volumetric depth images of Frey, Sadlo, Ertl 2013.
// A segment lies between two forward depths of its pixel's ray and is taken as homogeneous; a ray's are near to far and do not overlap. Colours over one
// another are the ray's. In front of a ray's end, between its segments, nothing is; behind it nothing is known.
#pragma once

#include <cstdint>

#include "render/core/color.h"
#include "render/core/normal_code.h"
#include "render/core/sample.h"
#include "render/core/transfer_vector.h"

namespace warpscope {

/// Where a segment lies: depth codes of its frame's quantisation (sample.h), begin <= end. One whose codes are equal is as thin as codes can tell.
struct SegmentDepths {
  uint32_t begin, end;  // without values of their own: vectors of millions of them would be filled with these before they are overwritten

  bool operator==(const SegmentDepths&) const = default;
};

/// What a pixel's ray has, in a byte: how many segments, and whether it ended behind the last of them (else it was followed until it left the volume).
class RaySegmentCount {
 public:
  WARPSCOPE_HD RaySegmentCount() = default;
  WARPSCOPE_HD RaySegmentCount(int count, bool isEnded) : bits_(static_cast<uint8_t>(count | (isEnded ? kEnded : 0))) {}
  WARPSCOPE_HD static RaySegmentCount ofBits(uint8_t bits) {
    RaySegmentCount count;
    count.bits_ = bits;
    return count;
  }

  WARPSCOPE_HD int count() const { return bits_ & kCountMask; }
  WARPSCOPE_HD bool isEnded() const { return (bits_ & kEnded) != 0; }
  WARPSCOPE_HD uint8_t bits() const { return bits_; }
  bool operator==(const RaySegmentCount&) const = default;

 private:
  static constexpr uint8_t kEnded = 0x80, kCountMask = 0x1f;
  uint8_t bits_ = 0;
};

/// Most segments that a frame has places for.
inline constexpr size_t kMostFrameSegments = size_t{1} << 28;

/// Of a frame.
struct FrameSegments {
  TransferVector<RaySegmentCount> rays;  ///< one for each pixel of the frame's picture, row by row; empty where the frame has no segments
  TransferVector<SegmentDepths> depths;   ///< of all rays, one ray after the other
  TransferVector<Rgba8> colors;          ///< as many; see segmentColor() and segmentColorScale()
  TransferVector<NormalCode> normals;    ///< as many, where what light makes of a place depends on the eye (relight.h); else none

  bool empty() const { return rays.empty(); }
  size_t size() const { return depths.size(); }
  /// In memory.
  size_t sizeBytes() const { return rays.size() + depths.size() * (sizeof(SegmentDepths) + sizeof(Rgba8)) + normals.size() * sizeof(NormalCode); }
};

/// Where between its ends a segment of that opacity lets half of its light through from in front, about: a share of its length (within 0.07).
WARPSCOPE_HD inline float placeOfHalf(float opacity) { return mulAdd(opacity * opacity, -0.375f, 0.5f); }

/// Opacity of a segment whose code is that of full opacity: what is left behind it is what a ray ends at by default, and the logarithm is finite.
inline constexpr float kMostSegmentOpacity = 1.0f - 1.0f / 1024;

/// Colours of segments are as those of samples, but for opacity, whose code is its root: light things in front of dark ones are what several segments a ray are
/// for, and an opacity of 1 in 100 has 26 codes below it instead of 3.
/// Of a code as a number. `Number`: float, or a vector of them.
template <class Number>
WARPSCOPE_HD inline Number opacityOfWholeCode(const Number& code) {
  const Number root = code / 255.0f;
  return root * root;
}
WARPSCOPE_HD inline float segmentOpacity(Rgba8 code) { return opacityOfWholeCode(static_cast<float>(code >> 24)); }
/// The nearest code of an opacity in [0, 1], as a number.
template <class Number>
WARPSCOPE_HD inline Number wholeSegmentOpacityCode(const Number& opacity) {
  const Number code = converted(truncated(minOf(sqrtOf(maxOf(opacity, 0.0f)), 1.0f) * 255.0f + 0.5f));
  // Of two beside each other the one whose square is nearer, which is not always the one nearer to the root.
  return selected(absOf(opacity - opacityOfWholeCode<Number>(code - 1.0f)) < absOf(opacityOfWholeCode(code) - opacity), maxOf(code - 1.0f, 0.0f), code);
}
WARPSCOPE_HD inline uint32_t segmentOpacityCode(float opacity) { return static_cast<uint32_t>(wholeSegmentOpacityCode(opacity)); }
/// What colours of segments that have normals (0 among them) are multiplied by before they are encoded: what highlights add may be more than white.
inline constexpr float kLitScale = 0.5f;
WARPSCOPE_HD constexpr float segmentColorScale(bool hasNormals) { return hasNormals ? kLitScale : 1.0f; }

/// Linear, of what is opaque. `scale`: segmentColorScale().
WARPSCOPE_HD inline glm::vec3 straightSegmentColor(const ColorTables& tables, Rgba8 code, float scale = 1.0f) {
  return glm::vec3(tables.decode(code | 0xff000000u)) * (1.0f / scale);
}
/// Linear, premultiplied.
WARPSCOPE_HD inline glm::vec4 segmentColor(const ColorTables& tables, Rgba8 code, float scale = 1.0f) {
  const float opacity = segmentOpacity(code);
  return {opacity * straightSegmentColor(tables, code, scale), opacity};
}

/// Where a pixel's segments go: as many places as the settings ask for segments. `normals` may be null.
struct SegmentSlots {
  SegmentDepths* depths = nullptr;
  Rgba8* colors = nullptr;
  NormalCode* normals = nullptr;
};

}  // namespace warpscope
