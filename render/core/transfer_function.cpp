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
  const float fraction = static_cast<float>((value - before.value) / (next->value - before.value));
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
  for (int i = 0; i < TransferTable::kSize; ++i) {
    const double value = lower + (upper - lower) * i / (TransferTable::kSize - 1);
    const glm::vec4 straight = function.at(value);
    const float alpha = correctOpacity(std::clamp(straight.a, 0.0f, 1.0f), step);
    table.entries[i] = {glm::vec3(straight) * alpha, alpha};
    table.visibleBefore[i + 1] = table.visibleBefore[i] + (alpha > 0.0f ? 1 : 0);
  }
  return table;
}

}  // namespace warpscope
