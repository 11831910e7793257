// Evaluation of transfer functions.
// See transfer_function.h.
#include "render/core/transfer_function.h"

#include <algorithm>
#include <limits>
#include <string>

#include "render/base/error.h"

namespace warpscope {
namespace {

using Points = std::vector<TransferPoint>;

/// The function at `value`, which lies between the corners before `next` and `next`, or beyond an end.
glm::vec4 between(const Points& points, Points::const_iterator next, double value) {
  if (next == points.begin()) return {points.front().color, points.front().alpha};
  const TransferPoint& before = *std::prev(next);
  if (next == points.end()) return {before.color, before.alpha};
  const double extent = next->value - before.value;
  const double unit = std::isfinite(extent) ? (value - before.value) / extent  // else halves, whose difference does not overflow
                                            : (0.5 * value - 0.5 * before.value) / (0.5 * next->value - 0.5 * before.value);
  const float fraction = static_cast<float>(unit);
  return {glm::mix(before.color, next->color, fraction), glm::mix(before.alpha, next->alpha, fraction)};
}

}  // namespace

glm::vec4 TransferFunction::at(double value) const {
  if (points.empty()) return glm::vec4(0.0f);
  // The first corner beyond the value: with repeated values this is past all of them, which makes "from it on" hold.
  return between(points,
                 std::upper_bound(points.begin(), points.end(), value, [](double v, const TransferPoint& point) { return v < point.value; }),
                 value);
}

glm::vec4 TransferFunction::below(double value) const {
  if (points.empty()) return glm::vec4(0.0f);
  return between(points,
                 std::lower_bound(points.begin(), points.end(), value, [](const TransferPoint& point, double v) { return point.value < v; }),
                 value);
}

void validate(const TransferFunction& function) {
  if (function.points.empty()) throw UsageError("a transfer function needs a point");
  if (function.points.size() > kMostTransferPoints)
    throw UsageError("a transfer function has at most " + std::to_string(kMostTransferPoints) + " points, not " + std::to_string(function.points.size()));
  double last = -std::numeric_limits<double>::infinity();
  for (const TransferPoint& point : function.points) {
    if (!std::isfinite(point.value) || point.value < last) throw UsageError("a transfer function's values are finite, and none is less than the one before");
    last = point.value;
    for (const float share : {point.color.r, point.color.g, point.color.b, point.alpha})
      if (!(share >= 0.0f && share <= 1.0f)) throw UsageError("a transfer function's colours and opacities are 0 to 1");
  }
}

std::pair<double, double> TransferFunction::changingValues() const {
  const auto sameLook = [](const TransferPoint& a, const TransferPoint& b) { return a.color == b.color && a.alpha == b.alpha; };
  size_t first = 0, last = points.size() - 1;
  while (first < last && sameLook(points[first + 1], points.front())) ++first;
  while (last > first && sameLook(points[last - 1], points.back())) --last;
  return {points[first].value, points[last].value};
}

}  // namespace warpscope
