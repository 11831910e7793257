// A ray's segments into the codes that a frame has. For host and device.
// What rounding leaves is handed on to what lies behind: error diffusion (Floyd, Steinberg 1976) along a ray.
#pragma once

#include "render/march/frame_segments.h"
#include "render/march/ray_segments.h"

namespace warpscope {

/// Of a segment's opacity, what its colours and its opacity may differ by from what they are, for what rounding has left of those in front of it.
inline constexpr float kMostDiffused = 1.0f / 32;

/// What an encoder of numbers of that kind does by tables and whole numbers. float; vectors of them: segment_batch_encoder.cpp.
template <class Number>
struct SegmentCoding;
template <>
struct SegmentCoding<float> {
  using Whole = int;

  WARPSCOPE_HD static Whole encodeChannel(const ColorTables& tables, float linear) { return static_cast<int>(tables.encodeChannel(linear)); }
  WARPSCOPE_HD static float decodeChannel(const ColorTables& tables, Whole code) { return tables.decode(static_cast<Rgba8>(code) | 0xff000000u).r; }
};

/// A ray's segments as codes. Colours and opacities are rounded to 8 bits each so that what all up to one show over one another is off by less than a code of
/// what that one alone contributes: each is given what rounding has left of those in front of it. `Number`: float, or a vector of as many rays as it has lanes. For host and device.
template <class Number>
class BasicSegmentEncoder {
 public:
  using Coding = SegmentCoding<Number>;
  using Whole = typename Coding::Whole;
  struct Codes {
    Whole begin, end, color;  ///< SegmentDepths', Rgba8's bits
  };

  /// `hasNormals`: normals are sent with what is encoded.
  WARPSCOPE_HD BasicSegmentEncoder(const ColorTables& tables, const SampleQuantization& quantization, const Number& cosine, bool hasNormals)
      : tables_(tables), colorScale_(segmentColorScale(hasNormals)), depthStep_(quantization.depthStep), cosine_(cosine) {}

  /// False if it shows nothing in 8 bits: then what it has is given to the next, and it is not to be sent.
  /// Of a segment that has others behind it something is left to pass, so that those have something to show.
  template <class Segment, class Is>
  WARPSCOPE_HD Is encode(const Segment& segment, const Is& isLast, Codes& codes) {
    // What all up to this one come to, exactly; then what this one has to be for that.
    for (int channel = 0; channel < 3; ++channel) color_[channel] = mulAdd(through_, segment.color[channel], color_[channel]);
    through_ = through_ * (1.0f - segment.opacity);
    const Is passes = sentThrough_ > Number(0.0f);
    const Number share = 1.0f / selected(passes, sentThrough_, Number(1.0f));
    // No further from what it is than a share of its opacity: else one that hardly shows, of little opacity or behind much, is given all that rounding has left, and a hue
    // of its own that shows from beside.
    const Number most = kMostDiffused * segment.opacity;
    const auto wanted = [&](const Number& value, const Number& own) -> Number { return minOf(maxOf(value, own - most), own + most); };
    const Number code = wholeSegmentOpacityCode<Number>(minOf(wanted(1.0f - through_ * share, segment.opacity), 1.0f));
    const Number opacity = minOf(code, selected(isLast, Number(255.0f), Number(254.0f)));
    const Is isSent = passes && opacity > Number(0.0f);
    const Number sentOpacity = opacityOfWholeCode(opacity), straight = colorScale_ / selected(isSent, sentOpacity, Number(1.0f));
    codes.color = truncated(opacity) << 24;
    for (int channel = 0; channel < 3; ++channel) {
      const Whole own = Coding::encodeChannel(tables_, wanted((color_[channel] - sentColor_[channel]) * share, segment.color[channel]) * straight);
      codes.color = codes.color | own << (8 * channel);
      const Number sent = sentOpacity * (Coding::decodeChannel(tables_, own) * (1.0f / colorScale_));
      sentColor_[channel] = selected(isSent, mulAdd(sentThrough_, sent, sentColor_[channel]), sentColor_[channel]);
    }
    sentThrough_ = selected(isSent, sentThrough_ * (1.0f - sentOpacity), sentThrough_);
    codes.begin = signedDepthCode<Number>(segment.begin * cosine_, depthStep_);
    codes.end = signedDepthCode<Number>(segment.end * cosine_, depthStep_);
    return isSent;
  }

 private:
  const ColorTables& tables_;
  float colorScale_;
  Number depthStep_, cosine_;
  Number color_[3] = {Number(0.0f), Number(0.0f), Number(0.0f)}, sentColor_[3] = {Number(0.0f), Number(0.0f), Number(0.0f)};  // of all so far
  Number through_ = Number(1.0f), sentThrough_ = Number(1.0f);
};
using SegmentEncoder = BasicSegmentEncoder<float>;

/// Stores a ray's segments, near to far, and says how many there are. `normalOf(i)` is the normal of the segment in place i. For host and device.
template <class Merger, class NormalOf>
WARPSCOPE_HD inline RaySegmentCount storeSegments(const Merger& found, bool isEnded, SegmentEncoder encoder, const SegmentSlots& slots,
                                                  const NormalOf& normalOf) {
  int count = 0;
  for (int i = found.first(); i != Merger::kNone; i = found.behind(i)) {
    const bool isLast = found.behind(i) == Merger::kNone;
    SegmentEncoder::Codes codes;
    if (!encoder.encode(found[i], isLast, codes)) continue;
    slots.depths[count] = {static_cast<uint32_t>(codes.begin), static_cast<uint32_t>(codes.end)};
    slots.colors[count] = static_cast<Rgba8>(codes.color);
    if (slots.normals != nullptr) slots.normals[count] = normalOf(i);
    ++count;
  }
  return {count, isEnded};
}

}  // namespace warpscope
