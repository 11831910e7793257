// The one thread on which sockets live: everything in this room that says "on the I/O thread" means its.
// An io_context that is kept running until it is told to stop.
#pragma once

#include <exception>
#include <future>
#include <thread>

#include "net/timer.h"

namespace warpscope::net {

class IoThread {
 public:
  /// `clock`: of everything that waits on the thread; it must outlive it.
  explicit IoThread(Clock& clock = steadyClock()) : clock_(clock), work_(asio::make_work_guard(context_)) {
    setClock(context_, clock);
    thread_ = std::thread([this] { run(); });
  }
  /// Stops: what is still waited for is dropped.
  ~IoThread() {
    work_.reset();
    context_.stop();
    thread_.join();
  }
  IoThread(const IoThread&) = delete;
  IoThread& operator=(const IoThread&) = delete;

  asio::io_context& context() { return context_; }
  Clock& clock() const { return clock_; }

  /// Calls `f` on the thread and waits for it. Throws what it throws. Not to be called on the thread itself.
  template <class F>
  auto call(F&& f) {
    std::packaged_task<decltype(f())()> task(std::forward<F>(f));
    auto result = task.get_future();
    asio::post(context_, [&task] { task(); });
    return result.get();
  }

 private:
  void run() {
    // Coroutines deal with their own errors; one that escapes is a bug, but not a reason to stop serving the others.
    while (true) {
      try {
        context_.run();
        return;
      } catch (const std::exception&) {
      }
    }
  }

  Clock& clock_;
  asio::io_context context_{1};
  asio::executor_work_guard<asio::io_context::executor_type> work_;
  std::thread thread_;
};

}  // namespace warpscope::net
