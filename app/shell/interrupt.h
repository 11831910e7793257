// Ctrl-C, SIGTERM and a closed terminal (SIGHUP) as a stop token, so that long work ends by itself and cleans up.
// Boost.Asio signal_set on a thread of its own.
#pragma once

#include <memory>
#include <stop_token>

namespace warpscope {

/// While it lives, an interrupt requests a stop instead of ending the process; the next one ends the process at once. Those that follow within a
/// quarter of a second count as the first: a key that bounces, or a launcher that passes on what the terminal has sent already. If ending takes longer
/// than a second, a line on standard error says what the next one will do. After a stop no interrupt has an effect any more: one object serves a process
/// until its end.
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

/// Whether one has asked for a stop, be its object there or not. Safe on any thread.
bool wasInterrupted();

}  // namespace warpscope
