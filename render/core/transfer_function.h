// Transfer functions: from a scalar to colour and opacity, and the baked, step-corrected table that marching reads.
// Opacity correction for a step of ds volume units: 1 - (1 - a)^ds = -expm1(ds * log1p(-a)) (cf. Engel et al. 2006, 9.1).
#pragma once

#include <cmath>
#include <vector>

#include "render/core/exact_math.h"
#include "render/core/numeric.h"

namespace warpscope {

/// Opacity of a piece of length `ds` of a medium whose opacity over unit length is `alpha`. 1 stays 1 for ds > 0.
/// The same float on every processor, and the nearest one unless the truth lies within 3e-15 of itself from the middle
/// between two.
WARPSCOPE_HD inline float correctOpacity(float alpha, float ds) {
  if (alpha >= 1.0f) return ds > 0.0f ? 1.0f : 0.0f;
  return static_cast<float>(oneMinusExp(static_cast<double>(ds) * logOfOneMinus(alpha)));
}

/// One corner of a piecewise linear transfer function. Two corners with the same value make a step: below it the first holds,
/// from it on the second.
struct TransferPoint {
  double value = 0.0;     ///< in the volume's own units
  glm::vec3 color{1.0f};  ///< linear RGB, straight, 0..1
  float alpha = 0.0f;     ///< opacity over one unit of volume space (the smallest voxel edge), 0..1

  bool operator==(const TransferPoint&) const = default;
};

/// A piecewise linear transfer function; constant beyond its ends.
struct TransferFunction {
  std::vector<TransferPoint> points;  ///< at least one, values finite and not decreasing

  /// Colour (straight, linear) and opacity at `value`.
  glm::vec4 at(double value) const;

  bool operator==(const TransferFunction&) const = default;
};

/// A transfer function sampled at kSize equidistant values over [lower, upper], corrected for one step length: entry i holds linear
/// colour premultiplied by the corrected opacity, and that opacity. Reading is by nearest entry, so that a step stays a step.
struct TransferTable {
  static constexpr int kSize = 4096;

  std::vector<glm::vec4> entries;   ///< kSize of them
  std::vector<int> visibleBefore;   ///< kSize + 1: how many of the first i entries have any opacity
  double lower = 0.0;               ///< value of entry 0
  double upper = 1.0;               ///< value of the last entry
  float step = 1.0f;                ///< volume units that the opacities are corrected for

  /// True if any value in [lowest, highest] (fractions of the table's range, clamped) has opacity.
  bool anyVisible(float lowest, float highest) const;
};

/// Index of the entry nearest to `unit`, a fraction of the table's range; clamps, and NaN gives entry 0, never one past the table.
/// Float is float or a vector of floats.
template <class Float>
WARPSCOPE_HD inline auto transferIndex(const Float& unit) {
  constexpr float last = TransferTable::kSize - 1;
  return truncated(mulAdd(saturated(unit), Float(last), Float(0.5f)));
}

/// Bakes `function` over [lower, upper] for steps of `step` volume units. A range without extent gives a table of its one value.
TransferTable bakeTransferTable(const TransferFunction& function, double lower, double upper, float step);

}  // namespace warpscope
