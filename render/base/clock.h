// Time as something that is handed in, so that delays are tested in virtual time: deterministic and without sleeping.
// Real time is std::chrono::steady_clock.
#pragma once

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <set>
#include <stop_token>

namespace warpscope {

class Clock {
 public:
  using TimePoint = std::chrono::steady_clock::time_point;
  using Duration = std::chrono::steady_clock::duration;

  virtual ~Clock() = default;
  virtual TimePoint now() const = 0;
  /// Sleeps until `time` and returns true, or false as soon as `stop` is set.
  virtual bool waitUntil(TimePoint time, const std::stop_token& stop) = 0;
};

inline double millisecondsBetween(Clock::TimePoint from, Clock::TimePoint to) {
  return std::chrono::duration<double, std::milli>(to - from).count();
}

inline Clock::Duration durationOfMs(double milliseconds) {
  return std::chrono::duration_cast<Clock::Duration>(std::chrono::duration<double, std::milli>(milliseconds));
}

class SteadyClock final : public Clock {
 public:
  TimePoint now() const override { return std::chrono::steady_clock::now(); }
  bool waitUntil(TimePoint time, const std::stop_token& stop) override;
};

/// Starts at 0 and stands still until it is told to move on.
class VirtualClock final : public Clock {
 public:
  TimePoint now() const override;
  bool waitUntil(TimePoint time, const std::stop_token& stop) override;

  /// Moves on and wakes whoever's time has come.
  void advance(Duration duration);
  /// Waits, in real time, until some thread sleeps; then moves on to the first time for which one does, and returns it.
  TimePoint advanceToNextSleeper();

 private:
  void moveTo(TimePoint time);

  mutable std::mutex mutex_;
  std::condition_variable_any changed_;
  TimePoint now_{};
  std::multiset<TimePoint> sleepers_;  // when each wants to wake up; those whose time has come are gone already
};

}  // namespace warpscope
