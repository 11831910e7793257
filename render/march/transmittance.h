// What light is left along a ray, front to back.
// Double precision: 10^6 samples of opacity 10^-8 add up instead of vanishing in rounding, and one multiplication is the whole chain.
#pragma once

#include "render/core/host_device.h"

namespace warpscope {

/// T, which is what is tracked; opacity is 1 - T. Never negative, never grows.
class Transmittance {
 public:
  WARPSCOPE_HD Transmittance() = default;
  WARPSCOPE_HD explicit Transmittance(double value) : value_(value) {}

  WARPSCOPE_HD float value() const { return static_cast<float>(value_); }
  WARPSCOPE_HD double exact() const { return value_; }
  WARPSCOPE_HD float opacity() const { return static_cast<float>(1.0 - value_); }

  /// Passes a sample of opacity `alpha` in [0, 1].
  WARPSCOPE_HD void pass(float alpha) { value_ *= 1.0 - static_cast<double>(alpha); }

 private:
  double value_ = 1.0;
};

}  // namespace warpscope
