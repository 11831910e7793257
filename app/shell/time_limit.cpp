// A thread that waits.
// See time_limit.h.
#include "app/shell/time_limit.h"

#include <condition_variable>
#include <mutex>

namespace warpscope {

TimeLimit::TimeLimit(std::optional<std::chrono::duration<double>> limit, const std::stop_token& outer)
    : onOuter_(outer, [this] { source_.request_stop(); }) {
  if (!limit) return;
  const auto end = std::chrono::steady_clock::now() + std::chrono::ceil<std::chrono::steady_clock::duration>(*limit);
  thread_ = std::jthread([this, end](const std::stop_token& lifted) {
    std::mutex mutex;
    std::condition_variable_any never;
    std::unique_lock lock(mutex);
    never.wait_until(lock, lifted, end, [] { return false; });
    if (lifted.stop_requested() || source_.stop_requested()) return;
    isOver_ = true;
    source_.request_stop();
  });
}

void TimeLimit::lift() {
  thread_.request_stop();
  if (thread_.joinable()) thread_.join();
}

}  // namespace warpscope
