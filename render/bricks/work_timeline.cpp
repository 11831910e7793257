// Slots two by two.
// See work_timeline.h.
#include "render/bricks/work_timeline.h"

#include <algorithm>
#include <cmath>

namespace warpscope {

void WorkTimeline::add(std::array<float, kSlots>& slots, double beginMs, double endMs) {
  if (!(beginMs >= 0.0 && endMs > beginMs && std::isfinite(endMs))) return;
  while (endMs > slotMs * static_cast<double>(kSlots)) {
    for (std::array<float, kSlots>* const both : {&marchMs, &waitMs}) {
      for (size_t i = 0; i < kSlots / 2; ++i) (*both)[i] = (*both)[2 * i] + (*both)[2 * i + 1];
      std::fill(both->begin() + kSlots / 2, both->end(), 0.0f);
    }
    slotMs *= 2.0;
  }
  for (auto slot = static_cast<size_t>(beginMs / slotMs); slot < kSlots && static_cast<double>(slot) * slotMs < endMs; ++slot) {
    const double from = static_cast<double>(slot) * slotMs;
    slots[slot] += static_cast<float>(std::max(0.0, std::min(endMs, from + slotMs) - std::max(beginMs, from)));
  }
}

double WorkTimeline::mostThreads() const {
  double mostMs = 0.0;
  for (size_t i = 0; i < kSlots; ++i) mostMs = std::max(mostMs, static_cast<double>(marchMs[i]) + static_cast<double>(waitMs[i]));
  return mostMs / slotMs;
}

}  // namespace warpscope
