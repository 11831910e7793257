// Taking a function apart and putting it together.
// See transfer_curves.h.
#include "app/scene/transfer_curves.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace warpscope {
namespace {

/// What a corner may differ by from what its neighbours make, to be left out.
constexpr float kSame = 1e-6f;

TransferFunction colorsAlone(const TransferCurves& curves) {
  TransferFunction function;
  for (const ColorCorner& corner : curves.colors) function.points.push_back({corner.value, corner.color, 0.0f});
  return function;
}

TransferFunction opacitiesAlone(const TransferCurves& curves) {
  TransferFunction function;
  for (const OpacityCorner& corner : curves.opacities) function.points.push_back({corner.value, glm::vec3(0.0f), corner.alpha});
  return function;
}

bool areAlike(const glm::vec4& a, const glm::vec4& b) {
  return std::abs(a.r - b.r) <= kSame && std::abs(a.g - b.g) <= kSame && std::abs(a.b - b.b) <= kSame && std::abs(a.a - b.a) <= kSame;
}

glm::vec4 lookOf(const TransferPoint& point) { return {point.color, point.alpha}; }

/// Without corners that lie on the line between their neighbours, or repeat the end's look beyond it.
std::vector<TransferPoint> simplified(const std::vector<TransferPoint>& points) {
  std::vector<TransferPoint> kept;
  for (size_t i = 0; i < points.size(); ++i) {
    const TransferPoint& point = points[i];
    if (!kept.empty() && i + 1 < points.size()) {
      const TransferPoint &before = kept.back(), &next = points[i + 1];
      const bool isStep = point.value == before.value || point.value == next.value;
      const double extent = next.value - before.value;
      const float share = extent > 0.0 && std::isfinite(extent) ? static_cast<float>((point.value - before.value) / extent) : 0.0f;
      if (!isStep && extent > 0.0 && std::isfinite(extent) && areAlike(lookOf(point), glm::mix(lookOf(before), lookOf(next), share))) continue;
    }
    kept.push_back(point);
  }
  while (kept.size() > 1 && areAlike(lookOf(kept.back()), lookOf(kept[kept.size() - 2]))) kept.pop_back();
  while (kept.size() > 1 && areAlike(lookOf(kept[0]), lookOf(kept[1]))) kept.erase(kept.begin());
  return kept;
}

/// `value` between the neighbours of corner `i`, as far as there are any.
template <class Corners>
double betweenNeighbours(const Corners& corners, size_t i, double value) {
  if (i > 0) value = std::max(value, corners[i - 1].value);
  if (i + 1 < corners.size()) value = std::min(value, corners[i + 1].value);
  return value;
}

template <class Corners>
size_t placeFor(const Corners& corners, double value) {
  const auto place = std::ranges::upper_bound(corners, value, {}, [](const auto& corner) { return corner.value; });
  return static_cast<size_t>(place - corners.begin());
}

template <class Corners>
bool removeCorner(Corners& corners, size_t i) {
  if (corners.size() <= 1) return false;
  corners.erase(corners.begin() + static_cast<std::ptrdiff_t>(i));
  return true;
}

}  // namespace

TransferCurves curvesOf(const TransferFunction& function) {
  std::vector<TransferPoint> colors = function.points, opacities = function.points;
  for (TransferPoint& point : colors) point.alpha = 0.0f;
  for (TransferPoint& point : opacities) point.color = glm::vec3(0.0f);
  TransferCurves curves;
  for (const TransferPoint& point : simplified(colors)) curves.colors.push_back({point.value, point.color});
  for (const TransferPoint& point : simplified(opacities)) curves.opacities.push_back({point.value, point.alpha});
  return curves;
}

TransferFunction functionOf(const TransferCurves& curves) {
  const TransferFunction colors = colorsAlone(curves), opacities = opacitiesAlone(curves);
  std::vector<double> values;
  for (const TransferFunction* part : {&colors, &opacities})
    for (const TransferPoint& point : part->points) values.push_back(point.value);
  std::ranges::sort(values);
  values.erase(std::ranges::unique(values).begin(), values.end());
  TransferFunction function;
  for (const double value : values) {
    const TransferPoint below{value, glm::vec3(colors.below(value)), opacities.below(value).a}, at{value, glm::vec3(colors.at(value)), opacities.at(value).a};
    if (!(below == at)) function.points.push_back(below);
    function.points.push_back(at);
  }
  return function;
}

void moveOpacity(TransferCurves& curves, size_t corner, double value, float alpha) {
  OpacityCorner& moved = curves.opacities[corner];
  moved.value = betweenNeighbours(curves.opacities, corner, value);
  moved.alpha = std::clamp(alpha, 0.0f, 1.0f);
}

void moveColor(TransferCurves& curves, size_t corner, double value) {
  curves.colors[corner].value = betweenNeighbours(curves.colors, corner, value);
}

size_t addOpacity(TransferCurves& curves, double value) {
  const size_t place = placeFor(curves.opacities, value);
  const float alpha = opacitiesAlone(curves).at(value).a;
  curves.opacities.insert(curves.opacities.begin() + static_cast<std::ptrdiff_t>(place), {value, alpha});
  return place;
}

size_t keepBeyond(TransferCurves& curves, size_t corner, double lowest, double highest) {
  const OpacityCorner kept = curves.opacities[corner];
  if (corner + 1 == curves.opacities.size() && kept.value < highest) curves.opacities.push_back({highest, kept.alpha});
  if (corner > 0 || kept.value <= lowest) return corner;
  curves.opacities.insert(curves.opacities.begin(), {lowest, kept.alpha});
  return 1;
}

size_t addColor(TransferCurves& curves, double value) {
  const size_t place = placeFor(curves.colors, value);
  const glm::vec3 color(colorsAlone(curves).at(value));
  curves.colors.insert(curves.colors.begin() + static_cast<std::ptrdiff_t>(place), {value, color});
  return place;
}

bool removeOpacity(TransferCurves& curves, size_t corner) { return removeCorner(curves.opacities, corner); }
bool removeColor(TransferCurves& curves, size_t corner) { return removeCorner(curves.colors, corner); }

TransferCurves windowed(const TransferCurves& curves, double shift, double scale) {
  TransferCurves changed = curves;
  const double first = std::min(curves.colors.front().value, curves.opacities.front().value), last = std::max(curves.colors.back().value, curves.opacities.back().value);
  const double middle = 0.5 * first + 0.5 * last;
  const auto placed = [&](double value) { return middle + shift + (value - middle) * scale; };
  for (ColorCorner& corner : changed.colors) corner.value = placed(corner.value);
  for (OpacityCorner& corner : changed.opacities) corner.value = placed(corner.value);
  return changed;
}

}  // namespace warpscope
