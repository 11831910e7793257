// A stop token that is set after a time, or when another one is.
// By the steady clock: it is for people who wait.
#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <optional>
#include <stop_token>
#include <thread>

namespace warpscope {

class TimeLimit {
 public:
  /// Without `limit`, token() is set with `outer` alone.
  TimeLimit(std::optional<std::chrono::duration<double>> limit, const std::stop_token& outer);

  std::stop_token token() const { return source_.get_token(); }
  /// Whether it was the time that set the token.
  bool isOver() const { return isOver_; }
  /// From here on time does not count any more.
  void lift();

 private:
  std::stop_source source_;
  std::stop_callback<std::function<void()>> onOuter_;
  std::atomic<bool> isOver_ = false;
  std::jthread thread_;  // last: it uses the others
};

}  // namespace warpscope
