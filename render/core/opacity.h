// Opacity of an optical depth in single precision, from operations that every processor rounds alike.
// Reduction of arguments: Muller 2016, chapter 11; the series is that of the exponential.
#pragma once

#include "render/core/numeric.h"

namespace warpscope {

/// What opacityOf is off by, relative to itself.
inline constexpr double kDepthOpacityError = 4e-7;

/// 1 - exp(-depth) for depth >= 0 (infinity too); 0 for NaN. Precise relative to itself however small it is.
WARPSCOPE_HD inline float opacityOf(float depth) {
  depth = minOf(maxOf(depth, 0.0f), 80.0f);  // from there on it is 1 to the last bit
  const float turns = std::floor(mulAdd(depth, -1.44269504f, 0.5f));
  // ln 2 in two parts, so that the product with `turns` is exact in the first: |r| <= ln(2) / 2.
  const float r = mulAdd(turns, -1.42860677e-6f, mulAdd(turns, -0.693145752f, -depth));
  float tail = mulAdd(r, 1.0f / 5040, 1.0f / 720);
  tail = mulAdd(tail, r, 1.0f / 120);
  tail = mulAdd(tail, r, 1.0f / 24);
  tail = mulAdd(tail, r, 1.0f / 6);
  tail = mulAdd(tail, r, 0.5f);
  const float less = mulAdd(r * r, tail, r);  // exp(r) - 1
  const uint32_t exponent = static_cast<uint32_t>(static_cast<int32_t>(turns) + 127) << 23;
  float power;
  std::memcpy(&power, &exponent, sizeof power);
  return mulAdd(-power, less, 1.0f - power);
}

}  // namespace warpscope
