// Morton codes: the bits of three coordinates interleaved, x lowest, 21 bits each.
// After Morton 1966; the spreading by masks as in Warren, Hacker's Delight (2nd ed.), section 7-2.
#pragma once

#include <cstdint>

#include "render/core/host_device.h"

namespace warpscope {

/// Puts two zero bits between any two of the lowest 21 bits of `value`.
WARPSCOPE_HD inline uint64_t spreadBits3(uint64_t value) {
  value &= 0x1fffff;
  value = (value | value << 32) & 0x001f00000000ffffull;
  value = (value | value << 16) & 0x001f0000ff0000ffull;
  value = (value | value << 8) & 0x100f00f00f00f00full;
  value = (value | value << 4) & 0x10c30c30c30c30c3ull;
  value = (value | value << 2) & 0x1249249249249249ull;
  return value;
}

/// 63-bit Morton code of a cell of the 2^21-cell grid.
WARPSCOPE_HD inline uint64_t mortonCode(uint32_t x, uint32_t y, uint32_t z) {
  return spreadBits3(x) | spreadBits3(y) << 1 | spreadBits3(z) << 2;
}

}  // namespace warpscope
