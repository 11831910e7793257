// Evaluation and baking of transfer functions.
// See transfer_function.h.
#include "render/core/transfer_function.h"

#include <algorithm>

namespace warpscope {

glm::vec4 TransferFunction::at(double value) const {
  if (points.empty()) return glm::vec4(0.0f);
  // The first corner beyond the value: with repeated values this is past all of them, which makes "from it on" hold.
  const auto next = std::upper_bound(points.begin(), points.end(), value,
                                     [](double v, const TransferPoint& point) { return v < point.value; });
  if (next == points.begin()) return {points.front().color, points.front().alpha};
  const TransferPoint& before = *std::prev(next);
  if (next == points.end()) return {before.color, before.alpha};
  const double extent = next->value - before.value;
  const double unit = std::isfinite(extent) ? (value - before.value) / extent  // else halves, whose difference does not overflow
                                            : (0.5 * value - 0.5 * before.value) / (0.5 * next->value - 0.5 * before.value);
  const float fraction = static_cast<float>(unit);
  return {glm::mix(before.color, next->color, fraction), glm::mix(before.alpha, next->alpha, fraction)};
}

bool TransferTable::anyVisible(float lowest, float highest) const {
  if (!(lowest <= highest)) return false;
  return visibleBefore[transferIndex(highest) + 1] > visibleBefore[transferIndex(lowest)];
}

TransferTable bakeTransferTable(const TransferFunction& function, double lower, double upper, float step) {
  TransferTable table;
  table.lower = lower;
  table.upper = upper;
  table.step = step;
  table.entries.resize(TransferTable::kSize);
  table.visibleBefore.resize(TransferTable::kSize + 1, 0);
  constexpr int kLast = TransferTable::kSize - 1;
  const double extent = upper - lower;
  // The product first, so that whole values stay whole; extents of double volumes may overflow.
  const auto valueAt = [&](int i) {
    return std::isfinite(extent * kLast) ? lower + extent * i / kLast : std::lerp(lower, upper, static_cast<double>(i) / kLast);
  };
  for (int i = 0; i < TransferTable::kSize; ++i) {
    const double value = valueAt(i);
    const glm::vec4 straight = function.at(value);
    const float alpha = correctOpacity(std::clamp(straight.a, 0.0f, 1.0f), step);
    table.entries[i] = {glm::vec3(straight) * alpha, alpha};
    table.visibleBefore[i + 1] = table.visibleBefore[i] + (alpha > 0.0f ? 1 : 0);
  }
  return table;
}

}  // namespace warpscope
