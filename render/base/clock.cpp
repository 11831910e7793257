// Sleeping that can be interrupted, in real and in virtual time.
// See clock.h.
#include "render/base/clock.h"

#include <algorithm>

namespace warpscope {

bool SteadyClock::waitUntil(TimePoint time, const std::stop_token& stop) {
  std::mutex mutex;
  std::condition_variable_any never;
  std::unique_lock lock(mutex);
  never.wait_until(lock, stop, time, [] { return false; });
  return !stop.stop_requested();
}

Clock& steadyClock() {
  static SteadyClock clock;
  return clock;
}

Clock::TimePoint VirtualClock::now() const {
  const std::scoped_lock lock(mutex_);
  return now_;
}

bool VirtualClock::waitUntil(TimePoint time, const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  if (now_ >= time) return !stop.stop_requested();
  sleepers_.insert(time);
  changed_.notify_all();
  changed_.wait(lock, stop, [&] { return now_ >= time; });
  if (now_ < time) sleepers_.erase(sleepers_.find(time));  // stopped
  return !stop.stop_requested();
}

void VirtualClock::advance(Duration duration) {
  const std::scoped_lock lock(mutex_);
  moveTo(now_ + duration);
}

Clock::TimePoint VirtualClock::advanceToNextSleeper() {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] { return firstSleeper().has_value(); });
  moveTo(*firstSleeper());
  return now_;
}

bool VirtualClock::advanceToNextSleeper(TimePoint latest) {
  const std::scoped_lock lock(mutex_);
  const std::optional<TimePoint> first = firstSleeper();
  if (!first || *first > latest) return false;
  moveTo(*first);
  return true;
}

bool VirtualClock::hasSleeper(TimePoint time) const {
  const std::scoped_lock lock(mutex_);
  return sleepers_.contains(time) || alarms_.contains(time);
}

std::optional<Clock::AlarmId> VirtualClock::callAt(TimePoint time, std::function<void()> ring) {
  const std::scoped_lock lock(mutex_);
  const AlarmId id = ++lastAlarm_;
  if (time <= now_) {
    ring();
  } else {
    alarms_.emplace(time, Alarm{id, std::move(ring)});
    changed_.notify_all();
  }
  return id;
}

void VirtualClock::forget(AlarmId alarm) {
  const std::scoped_lock lock(mutex_);
  const auto found = std::ranges::find(alarms_, alarm, [](const auto& entry) { return entry.second.id; });
  if (found != alarms_.end()) alarms_.erase(found);
}

std::optional<Clock::TimePoint> VirtualClock::firstSleeper() const {
  if (sleepers_.empty() && alarms_.empty()) return std::nullopt;
  if (sleepers_.empty()) return alarms_.begin()->first;
  if (alarms_.empty()) return *sleepers_.begin();
  return std::min(*sleepers_.begin(), alarms_.begin()->first);
}

/// Alarms ring with the mutex held: forget() then waits for one that rings, and whoever sees the new time finds all of them rung.
void VirtualClock::moveTo(TimePoint time) {
  now_ = time;
  sleepers_.erase(sleepers_.begin(), sleepers_.upper_bound(now_));
  while (!alarms_.empty() && alarms_.begin()->first <= now_) alarms_.extract(alarms_.begin()).mapped().ring();
  changed_.notify_all();
}

}  // namespace warpscope
