// What light is left along a ray, front to back.
// Compensated subtraction after Kahan 1965: 10^6 samples of opacity 10^-8 add up instead of vanishing in rounding.
#pragma once

#include "render/core/host_device.h"

namespace warpscope {

/// T, which is what is tracked; opacity is 1 - T. Never negative, never grows.
class Transmittance {
 public:
  WARPSCOPE_HD Transmittance() = default;
  WARPSCOPE_HD explicit Transmittance(float value) : value_(value) {}

  WARPSCOPE_HD float value() const { return value_; }
  WARPSCOPE_HD float opacity() const { return (1.0f - value_) + correction_; }

  /// Passes a sample of opacity `alpha` in [0, 1].
  WARPSCOPE_HD void pass(float alpha) {
    const float taken = value_ * alpha + correction_;
    const float next = value_ - taken;
    if (!(next > 0.0f) || alpha >= 1.0f) {
      value_ = 0.0f;
      correction_ = 0.0f;
      return;
    }
    if (next > value_) return;  // the correction alone never adds light
    correction_ = taken - (value_ - next);
    value_ = next;
  }

 private:
  float value_ = 1.0f;
  float correction_ = 0.0f;  ///< what `value_` is too large by
};

}  // namespace warpscope
