// The one thread on which sockets live: everything in this room that says "on the I/O thread" means its.
// An io_context that is kept running until it is told to stop. Those who only hand the thread on need not compile Asio.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <type_traits>
#include <utility>

#include "net/times.h"

namespace boost::asio {
class io_context;
}

namespace warpscope::net {

class IoThread {
 public:
  /// `clock`: of everything that waits on the thread; it must outlive it.
  explicit IoThread(Clock& clock = steadyClock());
  /// Stops: what is still waited for is dropped.
  ~IoThread();
  IoThread(const IoThread&) = delete;
  IoThread& operator=(const IoThread&) = delete;

  boost::asio::io_context& context();
  Clock& clock() const;

  /// Calls `f` on the thread and waits for it. Throws what it throws. Not to be called on the thread itself.
  template <class F>
  auto call(F&& f) {
    using Result = decltype(f());
    if constexpr (std::is_void_v<Result>) {
      callAndWait(std::forward<F>(f));
    } else {
      std::optional<Result> result;
      callAndWait([&] { result.emplace(f()); });
      return std::move(*result);
    }
  }

 private:
  void callAndWait(const std::function<void()>& f);

  struct State;
  const std::unique_ptr<State> state_;
};

}  // namespace warpscope::net
