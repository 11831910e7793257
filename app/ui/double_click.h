// Tells two quick presses at one place from two presses, by when they happened instead of by when a picture was drawn.
// Dear ImGui compares times of its own frames and takes one press a frame, which misses most double clicks at few frames a second.
#pragma once

#include <optional>

#include "render/base/clock.h"
#include "render/core/host_device.h"

namespace warpscope::ui {

/// Between which times something happened: a window that was busy drawing learns of a press only afterwards.
struct Moment {
  Clock::TimePoint earliest, latest;
};

/// Presses of one button, in their order.
class DoubleClick {
 public:
  static constexpr std::chrono::milliseconds kLongest{350};  ///< from the first press to the second
  static constexpr double kReachPx = 6.0;                    ///< from the first place to the second, at scale 1

  /// True if this press and the one before may have happened within kLongest, and lie within `reach` of each other; `place` and `reach` in
  /// one unit. Both are used up then: a third press begins anew.
  bool press(const Moment& moment, const glm::dvec2& place, double reach) {
    const bool isSecond =
        first_ && moment.earliest - first_->moment.latest <= kLongest && glm::distance(place, first_->place) <= reach;
    if (isSecond)
      first_.reset();
    else
      first_ = Press{moment, place};
    return isSecond;
  }

 private:
  struct Press {
    Moment moment;
    glm::dvec2 place;
  };
  std::optional<Press> first_;
};

}  // namespace warpscope::ui
