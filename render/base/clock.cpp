// Sleeping that can be interrupted, in real and in virtual time.
// See clock.h.
#include "render/base/clock.h"

namespace warpscope {

bool SteadyClock::waitUntil(TimePoint time, const std::stop_token& stop) {
  std::mutex mutex;
  std::condition_variable_any never;
  std::unique_lock lock(mutex);
  never.wait_until(lock, stop, time, [] { return false; });
  return !stop.stop_requested();
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
  changed_.wait(lock, [&] { return !sleepers_.empty(); });
  moveTo(*sleepers_.begin());
  return now_;
}

void VirtualClock::moveTo(TimePoint time) {
  now_ = time;
  sleepers_.erase(sleepers_.begin(), sleepers_.upper_bound(now_));
  changed_.notify_all();
}

}  // namespace warpscope
