// Deadlines: a timer that ends an operation by closing what it works on, since single operations cannot be cancelled.
// The way of the Boost.Asio timeout examples, with the expiry as an error of its own.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "net/stream.h"
#include "net/timer.h"

namespace warpscope::net {

/// What was waited for did not come in time. Its code is timed_out.
class DeadlineExceeded : public system_error {
 public:
  /// `what`: "reading the greeting from 127.0.0.1:4711".
  explicit DeadlineExceeded(const std::string& what);
};

/// Calls `onExpiry` once, on `executor`, if it still exists when `deadline` has come. Lives and dies on that executor.
class Watchdog {
 public:
  Watchdog(const asio::any_io_executor& executor, TimePoint deadline, std::function<void()> onExpiry);
  ~Watchdog();
  Watchdog(const Watchdog&) = delete;
  Watchdog& operator=(const Watchdog&) = delete;

  bool hasExpired() const;

 private:
  struct State;
  std::shared_ptr<State> state_;
};

/// Awaits `operation` on `stream`. When `deadline` comes first, the stream is aborted, which ends the operation, and DeadlineExceeded is
/// thrown, also if the operation came to its end in the same moment. `what` is for its text: "reading the greeting".
template <class T>
Awaitable<T> withDeadline(Stream& stream, TimePoint deadline, std::string what, Awaitable<T> operation) {
  const Watchdog watchdog(stream.executor(), deadline, [&stream] { stream.abort(); });
  const auto requireInTime = [&] {
    if (watchdog.hasExpired()) throw DeadlineExceeded(what + " (" + stream.peer() + ")");
  };
  try {
    if constexpr (std::is_void_v<T>) {
      co_await std::move(operation);
      requireInTime();
    } else {
      T result = co_await std::move(operation);
      requireInTime();
      co_return result;
    }
  } catch (const system_error&) {
    requireInTime();
    throw;
  }
}

}  // namespace warpscope::net
