// Colours of samples as differences from what their neighbours make likely, and back.
// Prediction: band_layout.h; green is taken off red and blue. Slots are colours, one place on: the first stands for none and is 0.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

#include "render/codec/band_layout.h"
#include "render/core/color.h"

namespace warpscope {

inline int32_t channel(Rgba8 color, int shift) { return static_cast<int32_t>(color >> shift & 255); }

inline int32_t predictedChannel(const Rgba8* slots, const Neighbors& from, int shift) {
  return predicted(channel(slots[from.west], shift), channel(slots[from.north], shift), channel(slots[from.northWest], shift));
}

/// All channels of a colour at once, each of which wraps around.
class ColorChannels {
 public:
#if defined(__SSE2__)
  explicit ColorChannels(Rgba8 color) : bytes_(_mm_cvtsi32_si128(static_cast<int>(color))) {}
  Rgba8 color() const { return static_cast<Rgba8>(_mm_cvtsi128_si32(bytes_)); }

  friend ColorChannels operator+(const ColorChannels& a, const ColorChannels& b) { return ColorChannels(_mm_add_epi8(a.bytes_, b.bytes_)); }
  friend ColorChannels operator-(const ColorChannels& a, const ColorChannels& b) { return ColorChannels(_mm_sub_epi8(a.bytes_, b.bytes_)); }
  /// predicted() of each channel. The median of two and the plane through three is their sum without the third, held between both: what is lost is lost in both.
  static ColorChannels predicted(const ColorChannels& west, const ColorChannels& north, const ColorChannels& northWest) {
    const __m128i low = _mm_min_epu8(west.bytes_, north.bytes_), high = _mm_max_epu8(west.bytes_, north.bytes_);
    return west + north - ColorChannels(_mm_min_epu8(_mm_max_epu8(northWest.bytes_, low), high));
  }

 private:
  explicit ColorChannels(__m128i bytes) : bytes_(bytes) {}

  __m128i bytes_;
#else
  explicit ColorChannels(Rgba8 color) : color_(color) {}
  Rgba8 color() const { return color_; }

  friend ColorChannels operator+(const ColorChannels& a, const ColorChannels& b) {
    return ofEach([&](int shift) { return channel(a.color_, shift) + channel(b.color_, shift); });
  }
  friend ColorChannels operator-(const ColorChannels& a, const ColorChannels& b) {
    return ofEach([&](int shift) { return channel(a.color_, shift) - channel(b.color_, shift); });
  }
  static ColorChannels predicted(const ColorChannels& west, const ColorChannels& north, const ColorChannels& northWest) {
    return ofEach([&](int shift) { return warpscope::predicted(channel(west.color_, shift), channel(north.color_, shift), channel(northWest.color_, shift)); });
  }

 private:
  template <class F>
  static ColorChannels ofEach(const F& f) {
    Rgba8 color = 0;
    for (int shift = 0; shift < 32; shift += 8) color |= static_cast<Rgba8>(f(shift) & 255) << shift;
    return ColorChannels(color);
  }

  Rgba8 color_;
#endif
};

// Loops over all samples read and write through locals only: what they write cannot be what they read then.

/// Differences of `count` samples' opacities from their prediction; `slots` are their colours, one place on.
inline void putAlpha(const Rgba8* slots, const Neighbors* neighbors, size_t count, uint8_t* alpha) {
  for (size_t i = 0; i < count; ++i)
    alpha[i] = static_cast<uint8_t>(channel(slots[i + 1], 24) - predictedChannel(slots, neighbors[i], 24));
}

/// Makes colours of opacity alone.
inline void takeAlpha(const uint8_t* alpha, const Neighbors* neighbors, size_t count, Rgba8* slots) {
  Rgba8 last = 0;  // what slots[i] became, nearly always the western neighbour's: it need not come back from memory
  for (size_t i = 0; i < count; ++i) {
    const Neighbors from = neighbors[i];
    const int32_t west = channel(from.west == i ? last : slots[from.west], 24), north = channel(slots[from.north], 24);
    const int32_t likely = predicted(west, north, channel(slots[from.northWest], 24));
    last = static_cast<Rgba8>((alpha[i] + likely) & 255) << 24;
    slots[i + 1] = last;
  }
}

/// Differences of opacities and colours from their prediction, a plane each; green's is taken off red's and blue's.
struct ColorDifferences {
  uint8_t* alpha;
  uint8_t* green;
  uint8_t* red;
  uint8_t* blue;
};

/// Of `count` samples; `slots` are their colours, one place on.
inline void putColors(const Rgba8* slots, const Neighbors* neighbors, size_t count, ColorDifferences out) {
  constexpr size_t kAtOnce = 16;  // so that planes are told apart in vectors
  Rgba8 differences[kAtOnce];
  for (size_t begin = 0; begin < count; begin += kAtOnce) {
    const size_t size = std::min(count - begin, kAtOnce);
    for (size_t i = 0; i < size; ++i) {
      const Neighbors from = neighbors[begin + i];
      const ColorChannels likely = ColorChannels::predicted(ColorChannels(slots[from.west]), ColorChannels(slots[from.north]), ColorChannels(slots[from.northWest]));
      differences[i] = (ColorChannels(slots[begin + i + 1]) - likely).color();
    }
    for (size_t i = 0; i < size; ++i) {
      const Rgba8 difference = differences[i], green = difference >> 8;
      out.alpha[begin + i] = static_cast<uint8_t>(difference >> 24);
      out.green[begin + i] = static_cast<uint8_t>(green);
      out.red[begin + i] = static_cast<uint8_t>(difference - green);
      out.blue[begin + i] = static_cast<uint8_t>((difference >> 16) - green);
    }
  }
}

/// Back.
inline void takeColors(ColorDifferences in, const Neighbors* neighbors, size_t count, Rgba8* slots) {
  for (size_t i = 0; i < count; ++i) {
    const Rgba8 green = in.green[i];
    slots[i + 1] = ((in.red[i] + green) & 255) | green << 8 | ((in.blue[i] + green) & 255) << 16 | static_cast<Rgba8>(in.alpha[i]) << 24;
  }
  ColorChannels last(slots[0]);  // what slots[i] became, nearly always the western neighbour's: it need not come back from memory
  for (size_t i = 0; i < count; ++i) {
    const Neighbors at = neighbors[i];
    const ColorChannels west = at.west == i ? last : ColorChannels(slots[at.west]);
    last = ColorChannels::predicted(west, ColorChannels(slots[at.north]), ColorChannels(slots[at.northWest])) + ColorChannels(slots[i + 1]);
    slots[i + 1] = last.color();
  }
}

}  // namespace warpscope
