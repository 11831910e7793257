// Waiting on an executor by the clock that its context was handed: the only way in which anything in this room waits for a time.
// In real time a timer is asio::steady_timer and nothing else; by a clock that is moved by hand, its alarms end the wait.
#pragma once

#include <functional>
#include <memory>

#include "net/asio.h"

namespace warpscope::net {

/// Hands `context` its clock, before anything on it asks for one. The clock must outlive the context.
void setClock(asio::execution_context& context, Clock& clock);
/// The clock of the executor's context; steadyClock() if it was handed none.
Clock& clockOf(const asio::any_io_executor& executor);

/// A time that coroutines wait for. Lives and dies on its executor.
class Timer {
 public:
  /// TimePoint::max() never comes.
  explicit Timer(const asio::any_io_executor& executor, TimePoint time = TimePoint::max());
  /// Ends all waits.
  ~Timer();
  Timer(const Timer&) = delete;
  Timer& operator=(const Timer&) = delete;

  Clock& clock() const;
  /// Ends all waits for the time before.
  void setTo(TimePoint time);
  /// Ends all waits. Later ones wait for the time all the same.
  void cancel() noexcept;
  /// Until the time has come, or somebody ends the wait, also by destroying the timer.
  Awaitable<void> wait();
  /// The same for who is no coroutine: `then` is called on the executor, and told whether the time has come.
  void onEnd(std::function<void(bool hasCome)> then);

 private:
  struct State;
  std::shared_ptr<State> state_;
};

}  // namespace warpscope::net
