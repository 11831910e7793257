// The timer, and what it leaves alone once the watchdog is gone.
// See deadline.h.
#include "net/deadline.h"

namespace warpscope::net {

DeadlineExceeded::DeadlineExceeded(const std::string& what) : system_error(asio::error::timed_out, what) {}

struct Watchdog::State {
  State(const asio::any_io_executor& executor, TimePoint deadline, std::function<void()> action)
      : timer(executor, deadline), onExpiry(std::move(action)) {}

  Timer timer;
  std::function<void()> onExpiry;  // empty once it was called or is no longer wanted
  bool hasExpired = false;
};

Watchdog::Watchdog(const asio::any_io_executor& executor, TimePoint deadline, std::function<void()> onExpiry)
    : state_(std::make_shared<State>(executor, deadline, std::move(onExpiry))) {
  // The handler may already be queued when the watchdog goes: the state outlives it, the action does not.
  state_->timer.onEnd([state = state_](bool hasCome) {
    if (!hasCome || !state->onExpiry) return;
    state->hasExpired = true;
    std::exchange(state->onExpiry, nullptr)();
  });
}

Watchdog::~Watchdog() {
  state_->onExpiry = nullptr;
  state_->timer.cancel();
}

bool Watchdog::hasExpired() const { return state_->hasExpired; }

}  // namespace warpscope::net
