// The one way in which work passes between threads: a slot that holds the newest value. Nothing can queue up.
// With the value that its reader works on, one is in flight and one pending; built on condition_variable_any's waits with stop tokens.
#pragma once

#include <condition_variable>
#include <mutex>
#include <optional>
#include <stop_token>
#include <utility>

namespace warpscope {

/// Safe for any number of threads on either side.
template <class T>
class Newest {
 public:
  /// Replaces what nobody has taken, and returns it: to destroy it may take long, which is for the caller to do without any lock.
  std::optional<T> put(T value) {
    std::optional<T> replaced(std::move(value));
    {
      const std::scoped_lock lock(mutex_);
      value_.swap(replaced);
    }
    arrived_.notify_one();
    return replaced;
  }

  /// What is there, if anything.
  std::optional<T> tryTake() {
    const std::scoped_lock lock(mutex_);
    return std::exchange(value_, std::nullopt);
  }

  /// Waits for a value; nothing if `stop` is set first.
  std::optional<T> take(const std::stop_token& stop) {
    std::unique_lock lock(mutex_);
    arrived_.wait(lock, stop, [&] { return value_.has_value(); });
    if (stop.stop_requested()) return std::nullopt;
    return std::exchange(value_, std::nullopt);
  }

  bool hasValue() const {
    const std::scoped_lock lock(mutex_);
    return value_.has_value();
  }

 private:
  mutable std::mutex mutex_;
  std::condition_variable_any arrived_;
  std::optional<T> value_;
};

}  // namespace warpscope
