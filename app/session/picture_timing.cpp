// Whose turn it is.
// See picture_timing.h.
#include "app/session/picture_timing.h"

#include <algorithm>

namespace warpscope {
namespace {

/// How long nothing must have happened before a picture is timed: the window, too, has drawn itself for the last time by then.
constexpr std::chrono::milliseconds kQuiet(600);

}  // namespace

void PictureTiming::update(std::span<LivePanel> panels, bool isAtRest, bool happened, TimePoint now) {
  if (happened || !isAtRest) quietSince_ = now;
  if (!isAtRest) stop(panels);
  for (size_t i = 0; i < panels.size() && !timing_ && now - quietSince_ >= kQuiet; ++i) {
    if (!panels[i].wantsTime()) continue;
    timing_ = i;
    panels[i].startTiming();
  }
}

bool PictureTiming::isOver(std::span<const LivePanel> panels, TimePoint now) const {
  return !timing_ && now - quietSince_ >= kQuiet && std::ranges::none_of(panels, &LivePanel::wantsTime);
}

bool PictureTiming::finish(size_t panel) {
  if (timing_ != panel) return false;  // it was stopped too late
  timing_.reset();
  return true;
}

void PictureTiming::stop(std::span<LivePanel> panels) {
  if (timing_) panels[*timing_].stopTiming();
  timing_.reset();
}

}  // namespace warpscope
