// A ray's segments into the codes that a frame has. For host and device.
// What rounding leaves is handed on to what lies behind: error diffusion (Floyd, Steinberg 1976) along a ray.
#pragma once

#include "render/march/frame_segments.h"
#include "render/march/ray_segments.h"

namespace warpscope {

/// Of a segment's opacity, what its colours and its opacity may differ by from what they are, for what rounding has left of those in front of it.
inline constexpr float kMostDiffused = 1.0f / 32;

/// A ray's segments as codes. Colours and opacities are rounded to 8 bits each so that what all up to one show over one another is off by less than a code of
/// what that one alone contributes: each is given what rounding has left of those in front of it. For host and device.
class SegmentEncoder {
 public:
  /// `hasNormals`: normals are sent with what is encoded.
  WARPSCOPE_HD SegmentEncoder(const ColorTables& tables, const SampleQuantization& quantization, float cosine, bool hasNormals)
      : tables_(tables), depthStep_(quantization.depthStep), cosine_(cosine), colorScale_(segmentColorScale(hasNormals)) {}

  /// False if it shows nothing in 8 bits: then what it has is given to the next, and it is not to be sent.
  /// Of a segment that has others behind it something is left to pass, so that those have something to show.
  WARPSCOPE_HD bool encode(const RaySegment& segment, bool isLast, SegmentDepths& depths, Rgba8& color) {
    // What all up to this one come to, exactly; then what this one has to be for that.
    for (int channel = 0; channel < 3; ++channel) color_[channel] = mulAdd(through_, segment.color[channel], color_[channel]);
    through_ *= 1.0f - segment.opacity;
    if (!(sentThrough_ > 0.0f)) return false;
    const float share = 1.0f / sentThrough_;
    // No further from what it is than a share of its opacity: else one that hardly shows, of little opacity or behind much, is given all that rounding has left, and a hue
    // of its own that shows from beside.
    const float most = kMostDiffused * segment.opacity;
    glm::vec4 wanted(0.0f);
    for (int channel = 0; channel < 3; ++channel)
      wanted[channel] = within((color_[channel] - sentColor_[channel]) * share, segment.color[channel] - most, segment.color[channel] + most);
    wanted.a = within(1.0f - through_ * share, segment.opacity - most, segment.opacity + most);
    uint32_t opacity = segmentOpacityCode(minOf(wanted.a, 1.0f));
    if (opacity == 0) return false;
    if (!isLast && opacity == 255) opacity = 254;
    const float straight = colorScale_ / segmentOpacity(opacity << 24);
    color = tables_.encodeChannel(wanted.r * straight) | tables_.encodeChannel(wanted.g * straight) << 8 | tables_.encodeChannel(wanted.b * straight) << 16 |
            opacity << 24;
    const glm::vec4 sent = segmentColor(tables_, color, colorScale_);
    for (int channel = 0; channel < 3; ++channel) sentColor_[channel] = mulAdd(sentThrough_, sent[channel], sentColor_[channel]);
    sentThrough_ *= 1.0f - sent.a;
    depths.begin = encodeDepth(segment.begin * cosine_, depthStep_);
    depths.end = encodeDepth(segment.end * cosine_, depthStep_);
    return true;
  }

 private:
  WARPSCOPE_HD static float within(float value, float least, float greatest) { return minOf(maxOf(value, least), greatest); }

  const ColorTables& tables_;
  float depthStep_, cosine_, colorScale_;
  glm::vec3 color_{0.0f}, sentColor_{0.0f};  // of all so far
  float through_ = 1.0f, sentThrough_ = 1.0f;
};

/// Stores a ray's segments, near to far, and says how many there are. `normalOf(i)` is the normal of the segment in place i. For host and device.
template <class Merger, class NormalOf>
WARPSCOPE_HD inline RaySegmentCount storeSegments(const Merger& found, bool isEnded, SegmentEncoder encoder, const SegmentSlots& slots,
                                                  const NormalOf& normalOf) {
  int count = 0;
  for (int i = found.first(); i != Merger::kNone; i = found.behind(i)) {
    const bool isLast = found.behind(i) == Merger::kNone;
    if (!encoder.encode(found[i], isLast, slots.depths[count], slots.colors[count])) continue;
    if (slots.normals != nullptr) slots.normals[count] = normalOf(i);
    ++count;
  }
  return {count, isEnded};
}

}  // namespace warpscope
