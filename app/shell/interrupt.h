// Ctrl-C, SIGTERM and a closed terminal (SIGHUP) as a stop token, so that long work ends by itself and cleans up.
// Boost.Asio signal_set on a thread of its own.
#pragma once

#include <memory>
#include <stop_token>

namespace warpscope {

/// While it lives, an interrupt requests a stop instead of ending the process. So do more of them, until the first has had two seconds:
/// the next then ends the process at once. After a stop no interrupt has an effect any more: one object serves a process until its end.
class Interrupt {
 public:
  /// Throws InputError if the system has nothing left to listen with.
  Interrupt();
  ~Interrupt();
  std::stop_token token() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace warpscope
