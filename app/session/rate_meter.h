// How often something happened lately.
// The mean over the last events within four seconds; nothing while there are none.
#pragma once

#include <array>

#include "render/base/clock.h"

namespace warpscope {

class RateMeter {
 public:
  void tick(Clock::TimePoint now) {
    times_[count_ % times_.size()] = now;
    ++count_;
  }

  /// Forgets what was: a pause is not a low rate.
  void clear() { count_ = 0; }

  /// Events a second; 0 if fewer than two lie within the window.
  double perSecond(Clock::TimePoint now) const {
    constexpr std::chrono::seconds kWindow(4);
    size_t events = 0;
    Clock::TimePoint first{}, last{};
    for (size_t back = 1; back <= times_.size() && back <= count_; ++back) {
      const Clock::TimePoint time = times_[(count_ - back) % times_.size()];
      if (now - time > kWindow) break;
      if (events == 0) last = time;
      first = time;
      ++events;
    }
    if (events < 2 || first == last) return 0.0;
    return static_cast<double>(events - 1) / std::chrono::duration<double>(last - first).count();
  }

 private:
  std::array<Clock::TimePoint, 64> times_{};
  size_t count_ = 0;
};

}  // namespace warpscope
