// Colours of samples as differences from what their neighbours make likely, and back.
// Prediction: band_layout.h; green is taken off red and blue. Slots are colours, one place on: the first stands for none and is 0.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

#include "render/codec/neighbor_rows.h"
#include "render/codec/neighbor_runs.h"
#include "render/core/color.h"
#include "render/core/transfer_vector.h"

namespace warpscope {

inline int32_t channel(Rgba8 color, int shift) { return static_cast<int32_t>(color >> shift & 255); }

inline int32_t predictedChannel(Rgba8 west, Rgba8 north, Rgba8 northWest, int shift) {
  return predicted(channel(west, shift), channel(north, shift), channel(northWest, shift));
}

/// All channels of a colour at once, each of which wraps around.
class ColorChannels {
 public:
  ColorChannels() : ColorChannels(Rgba8{0}) {}
  explicit operator Rgba8() const { return color(); }

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

/// Differences of samples' opacities from their prediction; `slots` are their colours, one place on.
inline void putAlpha(const Rgba8* slots, std::span<const NeighborRun> runs, uint8_t* __restrict__ alpha) {
  for (const NeighborRun& run : runs) {
    const RunSlots from(slots, run);
    for (size_t i = 0; i < run.size; ++i)
      alpha[run.begin + i] = static_cast<uint8_t>(channel(slots[run.begin + i + 1], 24) - predictedChannel(from.west[i], from.north[i], from.northWest[i], 24));
  }
}

/// Makes colours of opacity alone.
inline void takeAlpha(const uint8_t* alpha, std::span<const NeighborRun> runs, Rgba8* slots) {
  makeFromNeighbors(runs, making(slots, [alpha](size_t k, Rgba8 west, Rgba8 north, Rgba8 northWest) {
    return static_cast<Rgba8>((alpha[k] + predictedChannel(west, north, northWest, 24)) & 255) << 24;
  }));
}

/// Differences of opacities and colours from their prediction, a plane each; green's is taken off red's and blue's.
struct ColorDifferences {
  uint8_t* alpha;
  uint8_t* green;
  uint8_t* red;
  uint8_t* blue;
};

inline constexpr size_t kColorsAtOnce = 16;
/// Behind the last ones of all there is room for so many more, which are read, and written to.
inline constexpr size_t kSpareColors = kColorsAtOnce - 1;

/// Differences of kColorsAtOnce colours, channel by channel, each of which wraps around: as ColorChannels predicts.
inline void subtractPredicted(const Rgba8* own, const Rgba8* west, const Rgba8* north, const Rgba8* northWest, Rgba8* __restrict__ differences) {
  const auto bytesOf = [](const Rgba8* colors) { return reinterpret_cast<const uint8_t*>(colors); };
  const uint8_t *const o = bytesOf(own), *const w = bytesOf(west), *const n = bytesOf(north), *const corner = bytesOf(northWest);
  auto* const out = reinterpret_cast<uint8_t*>(differences);
  for (size_t i = 0; i < kColorsAtOnce * sizeof(Rgba8); ++i) {
    const uint8_t low = w[i] < n[i] ? w[i] : n[i], high = w[i] < n[i] ? n[i] : w[i];
    const uint8_t above = corner[i] < low ? low : corner[i], within = above < high ? above : high;
    out[i] = static_cast<uint8_t>(o[i] - w[i] - n[i] + within);
  }
}

inline void splitDifferences(const Rgba8* __restrict__ differences, size_t count, uint8_t* __restrict__ alpha, uint8_t* __restrict__ green, uint8_t* __restrict__ red,
                             uint8_t* __restrict__ blue) {
  for (size_t i = 0; i < count; ++i) {
    const Rgba8 difference = differences[i], ofGreen = difference >> 8;
    alpha[i] = static_cast<uint8_t>(difference >> 24);
    green[i] = static_cast<uint8_t>(ofGreen);
    red[i] = static_cast<uint8_t>(difference - ofGreen);
    blue[i] = static_cast<uint8_t>((difference >> 16) - ofGreen);
  }
}

/// Makes room for colours that putColors() is to be given: the first slot stands for none, and is 0 like those to spare.
inline void startColors(TransferVector<Rgba8>& slots, size_t count) {
  slots.resize(1 + count + kSpareColors);
  slots[0] = 0;
  std::fill(slots.begin() + 1 + static_cast<std::ptrdiff_t>(count), slots.end(), Rgba8{0});
}

/// Of `count` samples, whose colours have been put behind the first of the slots that startColors() made. `room`: to work in.
inline void putColors(const TransferVector<Rgba8>& colors, std::span<const NeighborRun> runs, size_t count, TransferVector<Rgba8>& room, ColorDifferences out) {
  room.resize(count + kSpareColors);
  const Rgba8* const slots = colors.data();
  Rgba8* const differences = room.data();
  for (const NeighborRun& run : runs) {
    const RunSlots from(slots, run);
    for (size_t i = 0; i < run.size; i += kColorsAtOnce) {  // what is written behind the run is written over by the next one
      const size_t k = run.begin + i;
      subtractPredicted(slots + k + 1, from.west + i, from.north + i, from.northWest + i, differences + k);
    }
  }
  splitDifferences(differences, count, out.alpha, out.green, out.red, out.blue);
}

/// Back: what the planes say, for makingColors(), which may make colours in its place, one place on, or elsewhere.
inline void joinDifferences(ColorDifferences in, size_t count, Rgba8* differences) {
  for (size_t i = 0; i < count; ++i) {
    const Rgba8 green = in.green[i];
    differences[i] = ((in.red[i] + green) & 255) | green << 8 | ((in.blue[i] + green) & 255) << 16 | static_cast<Rgba8>(in.alpha[i]) << 24;
  }
}
inline auto makingColors(const Rgba8* differences, Rgba8* slots) {
  const auto make = [differences](size_t k, const ColorChannels& west, const ColorChannels& north, const ColorChannels& northWest) {
    return ColorChannels::predicted(west, north, northWest) + ColorChannels(differences[k]);
  };
  return Making<Rgba8, ColorChannels, decltype(make)>(slots, make);
}
/// The same for rows (neighbor_rows.h).
struct ColorsInRows : ValuesInRows<Rgba8> {
  RowLanes make(const RowLanes& west, const RowLanes& north, const RowLanes& northWest, const std::array<RowLanes, kInputs>& inputs, RowLanes& color) const {
    return color = reinterpret_cast<RowLanes>(reinterpret_cast<ByteRowLanes>(predictedLanes<ByteRowLanes>(west, north, northWest)) + reinterpret_cast<ByteRowLanes>(inputs[0]));
  }
};

}  // namespace warpscope
