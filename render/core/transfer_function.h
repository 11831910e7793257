// Transfer functions: from a scalar to colour and opacity, as the user wrote them; and opacity over lengths.
// Opacity correction for a step of ds volume units: 1 - (1 - a)^ds = -expm1(ds * log1p(-a)) (cf. Engel et al. 2006, 9.1).
#pragma once

#include <cmath>
#include <utility>
#include <vector>

#include "render/core/exact_math.h"
#include "render/core/numeric.h"

namespace warpscope {

/// How near to the middle between two floats correctOpacity may take either, relative to the truth; and what it is off
/// by, which is what the nearest float may be off by.
inline constexpr double kOpacityTie = 3e-15;
inline constexpr double kOpacityError = 0x1p-24 + kOpacityTie;

/// Opacity of a piece of length `ds` of a medium whose opacity over unit length is `alpha`. 1 stays 1 for ds > 0.
/// The same float on every processor, and the nearest one unless the truth lies within kOpacityTie of itself from the
/// middle between two.
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
  /// What it comes to where values come to `value` from below: differs from at(value) at steps alone.
  glm::vec4 below(double value) const;
  /// First and last value between which it changes; there is at least one point.
  std::pair<double, double> changingValues() const;

  bool operator==(const TransferFunction&) const = default;
};

/// Corners that a function may have: as many as copies of volumes are sent with.
inline constexpr size_t kMostTransferPoints = 65536;

/// Throws UsageError for a function without points or with too many, with values that fall or are not finite, or with colours or opacities outside of 0..1.
void validate(const TransferFunction& function);

}  // namespace warpscope
