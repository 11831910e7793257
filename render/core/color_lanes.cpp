// Guesses, and all lanes go on until each has its code.
// See color_lanes.h.
#include "render/core/color_lanes.h"

#include "render/core/simd_lanes.h"

namespace warpscope {

IntBatch ColorLanes::encodeChannel(const ColorTables& tables, const FloatBatch& linear) {
  const FloatBatch zero(0.0f), one(1.0f);
  const auto isDark = !(linear > zero), isBright = linear >= one;
  const FloatBatch inside = xsimd::select(isDark || isBright, zero, linear);
  IntBatch code = gatheredBytes(tables.firstGuess_, xsimd::to_int(inside * static_cast<float>(ColorTables::kGuesses)));
  for (;;) {
    const auto isBeyond = gathered(tables.upperBound_, code) <= inside;
    if (!xsimd::any(isBeyond)) break;
    code += xsimd::to_int(xsimd::select(isBeyond, one, zero));
  }
  return xsimd::to_int(xsimd::select(isDark, zero, xsimd::select(isBright, FloatBatch(255.0f), xsimd::to_float(code))));
}

FloatBatch ColorLanes::decodeChannel(const ColorTables& tables, const IntBatch& code) { return gathered(tables.linear_, code); }

}  // namespace warpscope
