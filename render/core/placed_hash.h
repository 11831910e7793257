// A hash that is a sum over words: they may be taken in any order, on many threads.
// Multiplications and shifts in turns, as the finalizer of SplitMix64 has them (Steele, Lea, Flood 2014), with other numbers.
#pragma once

#include <cstdint>

#include "render/core/host_device.h"

namespace warpscope {

/// What a word at a place adds.
WARPSCOPE_HD inline uint64_t placedHash(uint64_t word, uint64_t index) {
  uint64_t mixed = word ^ (index + 1) * 0x9e3779b97f4a7c15u;
  mixed = (mixed ^ mixed >> 32) * 0xd6e8feb86659fd93u;
  mixed = (mixed ^ mixed >> 29) * 0x9e3779b97f4a7c15u;
  return mixed ^ mixed >> 32;
}

}  // namespace warpscope
