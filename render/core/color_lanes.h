// Colour codes of vectors of numbers: what ColorTables (color.h) does one at a time, a number a lane, by the same tables.
// xsimd; host only.
#pragma once

#include "render/core/color.h"
#include "render/core/simd.h"

namespace warpscope {

struct ColorLanes {
  /// ColorTables::encodeChannel().
  static IntBatch encodeChannel(const ColorTables& tables, const FloatBatch& linear);
  /// What a channel's codes say, linear.
  static FloatBatch decodeChannel(const ColorTables& tables, const IntBatch& code);
};

}  // namespace warpscope
