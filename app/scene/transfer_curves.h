// A transfer function as it is edited: colour and opacity apart, each a curve of corners of its own.
// The function itself (transfer_function.h) has one list of corners with both.
#pragma once

#include <vector>

#include "render/core/transfer_function.h"

namespace warpscope {

struct ColorCorner {
  double value = 0.0;
  glm::vec3 color{1.0f};  ///< linear RGB, straight

  bool operator==(const ColorCorner&) const = default;
};

struct OpacityCorner {
  double value = 0.0;
  float alpha = 0.0f;     ///< over one unit of volume space

  bool operator==(const OpacityCorner&) const = default;
};

/// Two piecewise linear curves, by values that do not fall; two corners with one value make a step.
struct TransferCurves {
  std::vector<ColorCorner> colors;       ///< at least one
  std::vector<OpacityCorner> opacities;  ///< at least one

  bool operator==(const TransferCurves&) const = default;
};

/// The curves of a function, without corners that the others make already.
TransferCurves curvesOf(const TransferFunction& function);
/// The function of both: curvesOf(functionOf(c)) shows what c does.
TransferFunction functionOf(const TransferCurves& curves);

// --- Edits. Corners keep their order: one that is moved stops at its neighbours.

/// Moves a corner, and says where it came to lie. `value` within `bounds` (first, last).
void moveOpacity(TransferCurves& curves, size_t corner, double value, float alpha);
void moveColor(TransferCurves& curves, size_t corner, double value);
/// Adds a corner on the curve, which does not change by that; its place.
size_t addOpacity(TransferCurves& curves, double value);
size_t addColor(TransferCurves& curves, double value);
/// Of a corner that is the first or the last: another one at the end of [lowest, highest] keeps the opacity that all beyond it has, wherever it goes. Its place from then on.
size_t keepBeyond(TransferCurves& curves, size_t corner, double lowest, double highest);
/// Removes a corner, unless it is the only one. False if it is.
bool removeOpacity(TransferCurves& curves, size_t corner);
bool removeColor(TransferCurves& curves, size_t corner);
/// Windowing: values a about the curves' middle become middle + shift + (a - middle) * scale. `scale` > 0.
TransferCurves windowed(const TransferCurves& curves, double shift, double scale);

}  // namespace warpscope
