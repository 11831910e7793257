// The curve of displays, both ways, for one value and for vectors of them, on host and device: what metrics see of a picture.
// IEC 61966-2-1; core/color.h has it in the standard's own words. The power is a polynomial here: off by 1.5e-7 at most.
#pragma once

#include "render/core/numeric.h"

namespace warpscope {

/// Linear 0..1 to sRGB 0..1; never decreases by more than a rounding. Beyond x = 0.0031308, 1.055 x^(5/12) - 0.055 is smooth in q = x^(1/4), which
/// goes from 0.24 to 1 there: interpolated at the Chebyshev nodes of degree 9, written out around 0.625.
template <class Real>
WARPSCOPE_HD inline Real srgbOf(const Real& linear) {
  const Real t = sqrtOf(sqrtOf(linear)) - Real(0.625f);
  Real curve = mulAdd(Real(-0.101911204f), t, Real(0.0796313487f));
  curve = mulAdd(curve, t, Real(-0.0340822281f));
  curve = mulAdd(curve, t, Real(0.0381584f));
  curve = mulAdd(curve, t, Real(-0.0491115039f));
  curve = mulAdd(curve, t, Real(0.0652754458f));
  curve = mulAdd(curve, t, Real(-0.121855512f));
  curve = mulAdd(curve, t, Real(0.685514439f));
  curve = mulAdd(curve, t, Real(1.28534937f));
  curve = mulAdd(curve, t, Real(0.427006065f));
  return selected(linear > Real(0.0031308f), minOf(curve, Real(1.0f)), Real(12.92f) * linear);
}

/// sRGB 0..1 to linear 0..1.
template <class Real>
WARPSCOPE_HD inline Real linearOf(const Real& srgb) {
  const Real curve = powOf((srgb + Real(0.055f)) * Real(1.0f / 1.055f), Real(2.4f));
  return selected(srgb > Real(0.04045f), curve, srgb * Real(1.0f / 12.92f));
}

}  // namespace warpscope
