// Colours of samples as differences from what their neighbours make likely, and back.
// Prediction: band_layout.h; green is taken off red and blue. Slots are colours, one place on: the first stands for none.
#pragma once

#include <cstddef>
#include <cstdint>

#include "render/codec/band_layout.h"
#include "render/core/color.h"

namespace warpscope {

inline int32_t channel(Rgba8 color, int shift) { return static_cast<int32_t>(color >> shift & 255); }

inline int32_t predictedChannel(const Rgba8* slots, const Neighbors& from, int shift) {
  return predicted(channel(slots[from.west], shift), channel(slots[from.north], shift), channel(slots[from.northWest], shift));
}

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

/// Differences of red, green and blue from their prediction, a plane each; green's is taken off the others'.
struct ColorDifferences {
  uint8_t* green;
  uint8_t* red;
  uint8_t* blue;
};

/// Of `count` samples; `slots` are their colours, one place on.
inline void putColors(const Rgba8* slots, const Neighbors* neighbors, size_t count, ColorDifferences out) {
  for (size_t i = 0; i < count; ++i) {
    const Neighbors from = neighbors[i];
    const Rgba8 color = slots[i + 1], west = slots[from.west], north = slots[from.north], northWest = slots[from.northWest];
    const auto difference = [&](int shift) {
      return channel(color, shift) - predicted(channel(west, shift), channel(north, shift), channel(northWest, shift));
    };
    const int32_t green = difference(8);
    out.green[i] = static_cast<uint8_t>(green);
    out.red[i] = static_cast<uint8_t>(difference(0) - green);
    out.blue[i] = static_cast<uint8_t>(difference(16) - green);
  }
}

/// Back: adds red, green and blue to slots that have their opacity alone.
inline void takeColors(ColorDifferences in, const Neighbors* neighbors, size_t count, Rgba8* slots) {
  Rgba8 last = slots[0];  // what slots[i] became, nearly always the western neighbour's: it need not come back from memory
  for (size_t i = 0; i < count; ++i) {
    const Neighbors at = neighbors[i];
    const Rgba8 west = at.west == i ? last : slots[at.west], north = slots[at.north], northWest = slots[at.northWest];
    const int32_t green = in.green[i];
    const auto decoded = [&](int shift, int32_t difference) {
      const int32_t likely = predicted(channel(west, shift), channel(north, shift), channel(northWest, shift));
      return static_cast<Rgba8>((likely + difference) & 255) << shift;
    };
    last = slots[i + 1] | decoded(8, green) | decoded(0, in.red[i] + green) | decoded(16, in.blue[i] + green);
    slots[i + 1] = last;
  }
}

}  // namespace warpscope
