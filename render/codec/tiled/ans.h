// Asymmetric numeral systems with ranges (rANS; Duda 2013, "Asymmetric numeral systems"): symbols of known frequencies as words of 16 bits, on kAnsLanes
// states side by side that share one stream, a state for each thread of a GPU's warp (after Giesen 2014, "Interleaved entropy coders").
// Integers alone, for host and device: every processor makes the same bytes.
//
// A state is at least kAnsLow and takes one word at a time. Writers go from the last symbol to the first, readers the other way: what a writer puts in front
// of a word is read before it. Numbers whose tokens do not say all (tokens.h) have the rest put behind the token, as bits that are all alike.
#pragma once

#include <cstddef>
#include <cstdint>

#include "render/core/host_device.h"

namespace warpscope {

inline constexpr uint32_t kAnsLanes = 32;
inline constexpr uint32_t kAnsBits = 12;
inline constexpr uint32_t kAnsScale = 1u << kAnsBits;  ///< what the frequencies of a model add up to
inline constexpr uint32_t kAnsLow = 1u << 16;          ///< where states begin; a reader's end there
inline constexpr uint32_t kAnsSymbols = 256;
/// Most bits of a number's rest that a state takes at once.
inline constexpr uint32_t kAnsRestBits = 16;

/// A symbol's share, or what a reader's state says: cumulated frequency below, frequency (less than kAnsScale; a model whose only symbol has all needs no coding).
struct AnsShare {
  uint32_t start = 0, frequency = 0;
};

/// Words that a writer's state has to give away before it takes a symbol: 0 or 1, `word` is set.
WARPSCOPE_HD inline bool ansGives(uint32_t& state, const AnsShare& share, uint16_t& word) {
  word = static_cast<uint16_t>(state);
  if (state < share.frequency << (32 - kAnsBits)) return false;
  state >>= 16;
  return true;
}
WARPSCOPE_HD inline uint32_t ansPut(uint32_t state, const AnsShare& share) {
  return (state / share.frequency << kAnsBits) + state % share.frequency + share.start;
}
/// What a writer does with a symbol, without dividing. The quotient of any word by the frequency is the upper half of one product and sum, shifted (Robison
/// 2005, "N-bit unsigned division via N-bit multiply-add"). Only symbols that occur, in models of more than one, are put: with a frequency of 1 to kAnsScale - 1.
struct AnsWriterShare {
  uint32_t multiplier = 0;
  uint32_t parts = 0;  ///< from below: start (12 bits), frequency (13), shift (4), whether the multiplier is added (1)

  static constexpr uint32_t kFrequencyAt = kAnsBits, kShiftAt = 2 * kAnsBits + 1, kAddsAt = kShiftAt + 4;

  WARPSCOPE_HD static AnsWriterShare of(const AnsShare& share) {
    if (share.frequency == 0) return {};
    AnsWriterShare own{0, share.start | share.frequency << kFrequencyAt};
    uint32_t shift = 0;
    while (share.frequency >> (shift + 1) != 0) ++shift;
    own.parts |= shift << kShiftAt;
    const uint64_t whole = uint64_t{1} << (32 + shift);
    const auto below = static_cast<uint32_t>(whole / share.frequency - (share.frequency == 1u << shift ? 1 : 0));
    const uint64_t tooMuch = uint64_t{below} * share.frequency + share.frequency - whole;  // if the multiplier were one more
    const bool adds = share.frequency == 1u << shift || tooMuch > uint64_t{1} << shift;
    own.multiplier = adds ? below : below + 1;
    own.parts |= (adds ? 1u : 0u) << kAddsAt;
    return own;
  }
  WARPSCOPE_HD uint32_t frequency() const { return parts >> kFrequencyAt & (2 * kAnsScale - 1); }
  /// Whether it has to give a word away first: then it goes on as state >> 16.
  WARPSCOPE_HD bool gives(uint32_t state) const { return state >= frequency() << (32 - kAnsBits); }
  /// As ansPut().
  WARPSCOPE_HD uint32_t put(uint32_t state) const {
    const uint64_t product = uint64_t{state} * multiplier + (parts >> kAddsAt != 0 ? multiplier : 0u);
    const uint32_t quotient = static_cast<uint32_t>(product >> 32) >> (parts >> kShiftAt & 15u);
    return state + (parts & (kAnsScale - 1)) + quotient * (kAnsScale - frequency());
  }
};

/// The same for `count` bits, 1 to kAnsRestBits.
WARPSCOPE_HD inline bool ansGivesForBits(uint32_t& state, uint32_t count, uint16_t& word) {
  word = static_cast<uint16_t>(state);
  if (state >> (32 - count) == 0) return false;
  state >>= 16;
  return true;
}
WARPSCOPE_HD inline uint32_t ansPutBits(uint32_t state, uint32_t bits, uint32_t count) { return state << count | bits; }

/// What a reader finds at a state's slot: symbol, frequency, how far behind its start the slot is, packed for tables of kAnsScale slots.
WARPSCOPE_HD inline uint32_t ansSlot(uint32_t symbol, uint32_t frequency, uint32_t behind) { return symbol | frequency << 8 | behind << 20; }
WARPSCOPE_HD inline uint32_t ansSymbolOf(uint32_t slot) { return slot & 255; }
WARPSCOPE_HD inline uint32_t ansTake(uint32_t state, uint32_t slot) { return (slot >> 8 & (kAnsScale - 1)) * (state >> kAnsBits) + (slot >> 20); }
/// Whether a reader's state needs a word: then it is state << 16 | word.
WARPSCOPE_HD inline bool ansWants(uint32_t state) { return state < kAnsLow; }

/// A symbol's frequency before rounding is made up for: 1 at least if it occurs. `total`: of all counts.
WARPSCOPE_HD inline uint16_t ansRounded(uint32_t count, uint64_t total) {
  if (count == 0) return 0;
  const uint64_t share = (uint64_t{count} * kAnsScale + total / 2) / total;
  return static_cast<uint16_t>(share == 0 ? 1 : share);
}
/// What the most frequent of such frequencies, which add up to `sum`, becomes: it bears best what rounding has left over or taken too much.
WARPSCOPE_HD inline uint16_t ansEvener(uint16_t most, uint32_t sum) {
  if (sum < kAnsScale) return static_cast<uint16_t>(most + (kAnsScale - sum));
  const uint32_t give = (most + 3u) / 4;
  return static_cast<uint16_t>(most - (give < sum - kAnsScale ? give : sum - kAnsScale));
}
/// Makes such frequencies, of which some symbol has one, kAnsScale in all.
WARPSCOPE_HD inline void ansEven(uint16_t* frequencies) {
  uint32_t sum = 0;
  for (uint32_t s = 0; s < kAnsSymbols; ++s) sum += frequencies[s];
  while (sum != kAnsScale) {
    uint32_t most = 0;
    for (uint32_t s = 1; s < kAnsSymbols; ++s)
      if (frequencies[s] > frequencies[most]) most = s;
    const uint16_t evener = ansEvener(frequencies[most], sum);
    sum = sum - frequencies[most] + evener;
    frequencies[most] = evener;
  }
}

}  // namespace warpscope
