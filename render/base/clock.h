// Time as something that is handed in, so that delays are tested in virtual time: deterministic and without sleeping.
// Real time is std::chrono::steady_clock.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
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

  using AlarmId = uint64_t;
  /// For those who wait without a thread. A clock that is moved by hand calls `ring` once when it has come to `time`, at once if it is there
  /// already; `ring` must not ask the clock. A clock that passes by itself returns nothing and calls nobody: the system's timers keep its time.
  virtual std::optional<AlarmId> callAt(TimePoint /*time*/, std::function<void()> /*ring*/) { return std::nullopt; }
  /// Once it returns, `ring` is not called and not being called. Alarms that have rung may be forgotten too.
  virtual void forget(AlarmId /*alarm*/) {}
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

/// The clock of whoever was not handed another one.
Clock& steadyClock();

/// Starts at 0 and stands still until it is told to move on.
class VirtualClock final : public Clock {
 public:
  TimePoint now() const override;
  bool waitUntil(TimePoint time, const std::stop_token& stop) override;
  std::optional<AlarmId> callAt(TimePoint time, std::function<void()> ring) override;
  void forget(AlarmId alarm) override;

  /// Moves on and wakes whoever's time has come.
  void advance(Duration duration);
  /// Waits, in real time, until somebody sleeps or has an alarm; then moves on to the first time for which one does, and returns it.
  TimePoint advanceToNextSleeper();
  /// As advanceToNextSleeper(), but does not wait: false, and the clock stands, if nobody wants to be woken by `latest`.
  bool advanceToNextSleeper(TimePoint latest);
  /// Whether somebody sleeps until exactly `time`, or has an alarm then.
  bool hasSleeper(TimePoint time) const;

 private:
  struct Alarm {
    AlarmId id;
    std::function<void()> ring;
  };

  std::optional<TimePoint> firstSleeper() const;
  void moveTo(TimePoint time);

  mutable std::mutex mutex_;
  std::condition_variable_any changed_;
  TimePoint now_{};
  std::multiset<TimePoint> sleepers_;  // when each wants to wake up; those whose time has come are gone already
  std::multimap<TimePoint, Alarm> alarms_;  // that have not rung
  AlarmId lastAlarm_ = 0;
};

}  // namespace warpscope
