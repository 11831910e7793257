// Logarithm and exponential of opacities from operations that every processor rounds alike, unlike libraries' functions.
// Series: Abramowitz, Stegun 1964, 4.1.27 (odd terms alone) and 4.2.1; reduction of arguments: Muller 2016, chapter 11.
#pragma once

#include <cmath>

#include "render/core/numeric.h"

namespace warpscope {

/// c0 + x * (c1 + x * (c2 + ...)), each step in one rounding.
template <class... Coefficients>
WARPSCOPE_HD inline double polynomial(double x, double c0, Coefficients... others) {
  if constexpr (sizeof...(others) == 0)
    return c0;
  else
    return mulAdd(polynomial(x, others...), x, c0);
}

inline constexpr double kLn2 = 0.69314718055994530942;
inline constexpr double kLog2E = 1.44269504088896340736;
inline constexpr double kSqrtHalf = 0.70710678118654752440;

/// What the two functions below are off by, at most, relative to the truth.
inline constexpr double kExactMathError = 1e-15;

/// log(1 - alpha) for alpha in [0, 1), precise relative to itself however small alpha is.
WARPSCOPE_HD inline double logOfOneMinus(float alpha) {
  const double a = static_cast<double>(alpha);
  const double rest = 1.0 - a;
  const double lost = (1.0 - rest) - a;  // what rounding took: rest + lost is 1 - alpha exactly
  int exponent = 0;
  double mantissa =
      std::frexp(rest, &exponent);  // rest = mantissa * 2^exponent, mantissa brought to [sqrt(1/2), sqrt(2))
  if (mantissa < kSqrtHalf) {
    mantissa *= 2.0;
    --exponent;
  }
  // log(m) = 2 artanh(s) with |s| < 0.172: what follows the 10 terms is below 2^-53 of them.
  const double s = (mantissa - 1.0) / (mantissa + 1.0);
  const double square = s * s;
  const double tail = square * polynomial(square, 1.0 / 3, 1.0 / 5, 1.0 / 7, 1.0 / 9, 1.0 / 11, 1.0 / 13, 1.0 / 15,
                                          1.0 / 17, 1.0 / 19, 1.0 / 21);
  const double ofMantissa = mulAdd(2.0 * s, tail, 2.0 * s) + lost / rest;
  return mulAdd(static_cast<double>(exponent), kLn2, ofMantissa);
}

/// 1 - exp(y) for y <= 0, precise relative to itself however small -y is.
WARPSCOPE_HD inline double oneMinusExp(double y) {
  if (y < -40.0) return 1.0;  // to the last bit
  const double turns = std::floor(mulAdd(y, kLog2E, 0.5));
  const double r = mulAdd(turns, -kLn2, y);  // |r| <= ln(2) / 2: what follows the 14 terms is below 2^-53 of them
  const double ofRest =
      r * polynomial(r, 1.0, 1.0 / 2, 1.0 / 6, 1.0 / 24, 1.0 / 120, 1.0 / 720, 1.0 / 5040, 1.0 / 40320, 1.0 / 362880,
                     1.0 / 3628800, 1.0 / 39916800, 1.0 / 479001600, 1.0 / 6227020800, 1.0 / 87178291200);
  const double power = std::ldexp(1.0, static_cast<int>(turns));
  return mulAdd(-power, ofRest, 1.0 - power);
}

}  // namespace warpscope
