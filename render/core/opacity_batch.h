// Opacities of several optical depths at once. Host only.
// The formula of opacity.h, in the same order: the same bits as one at a time.
#pragma once

#include "render/core/opacity.h"
#include "render/core/simd.h"

namespace warpscope {

/// opacityOf() of each.
inline FloatBatch opacityOf(const FloatBatch& given) {
  const FloatBatch depth = minOf(selected(given > FloatBatch(0.0f), given, FloatBatch(0.0f)), FloatBatch(80.0f));
  const FloatBatch turns = xsimd::floor(mulAdd(depth, FloatBatch(-1.44269504f), FloatBatch(0.5f)));
  const FloatBatch r = mulAdd(turns, FloatBatch(-1.42860677e-6f), mulAdd(turns, FloatBatch(-0.693145752f), -depth));
  FloatBatch tail = mulAdd(r, FloatBatch(1.0f / 5040), FloatBatch(1.0f / 720));
  for (const float factor : {1.0f / 120, 1.0f / 24, 1.0f / 6, 0.5f}) tail = mulAdd(tail, r, FloatBatch(factor));
  const FloatBatch less = mulAdd(r * r, tail, r);
  const FloatBatch power = floatOfBits((truncated(turns) + IntBatch(127)) << 23);
  return mulAdd(-power, less, FloatBatch(1.0f) - power);
}

}  // namespace warpscope
