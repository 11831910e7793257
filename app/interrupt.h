// Ctrl-C and SIGTERM as a stop token, so that long work ends by itself and cleans up.
// Boost.Asio signal_set on a thread of its own.
#pragma once

#include <memory>
#include <stop_token>

namespace warpscope {

/// While it lives, an interrupt requests a stop instead of ending the process; a second one ends it.
class Interrupt {
 public:
  Interrupt();
  ~Interrupt();
  std::stop_token token() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace warpscope
