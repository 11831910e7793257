// Scales and ticks.
// See plot_axis.h.
#include "app/picture/plot_axis.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace warpscope {

void AxisScale::include(double value) {
  if (!std::isfinite(value) || (isLogarithmic_ && value <= 0.0)) return;
  lowest_ = isEmpty_ ? value : std::min(lowest_, value);
  highest_ = isEmpty_ ? value : std::max(highest_, value);
  isEmpty_ = false;
}

void AxisScale::settle() {
  if (isEmpty_) lowest_ = isLogarithmic_ ? 0.1 : 0.0, highest_ = 1.0;
  if (isLogarithmic_) {
    lowest_ /= 1.25;
    highest_ *= 1.25;
  } else {
    if (highest_ == lowest_) highest_ = lowest_ + 1.0;
    const double margin = 0.04 * (highest_ - lowest_);
    lowest_ -= margin;
    highest_ += margin;
  }
}

double AxisScale::place(double value) const {
  if (std::isnan(value)) return value;
  const double shown = isLogarithmic_ ? std::max(value, lowest_) : value;
  const double share = isLogarithmic_ ? std::log(shown / lowest_) / std::log(highest_ / lowest_) : (shown - lowest_) / (highest_ - lowest_);
  return from_ + std::clamp(share, 0.0, 1.0) * (to_ - from_);
}

std::vector<double> AxisScale::ticks() const {
  constexpr size_t kFew = 3;
  std::vector<double> ticks;
  if (isLogarithmic_) {
    for (double power = std::pow(10.0, std::floor(std::log10(lowest_))); power <= highest_; power *= 10.0)
      for (const double factor : {1.0, 2.0, 5.0})
        if (factor * power >= lowest_ && factor * power <= highest_) ticks.push_back(factor * power);
    if (ticks.size() >= kFew) return ticks;
    ticks.clear();
  }
  const double rough = (highest_ - lowest_) / 6.0;
  const double power = std::pow(10.0, std::floor(std::log10(rough)));
  double step = 10.0 * power;
  for (const double factor : {1.0, 2.0, 2.5, 5.0})
    if (factor * power >= rough) {
      step = factor * power;
      break;
    }
  for (double i = std::ceil(lowest_ / step); i * step <= highest_; ++i) ticks.push_back(i * step + 0.0);  // never -0
  return ticks;
}

std::string tickText(double value) {
  const double magnitude = std::abs(value);
  const double unit = magnitude >= 1e6 ? 1e6 : magnitude >= 1e4 ? 1e3 : 1.0;
  char text[32];
  std::snprintf(text, sizeof text, "%.4g%s", value / unit + 0.0, unit == 1e6 ? " M" : unit == 1e3 ? " k" : "");
  return text;
}

}  // namespace warpscope
