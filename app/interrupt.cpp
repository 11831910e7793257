// Waiting for signals.
// See interrupt.h.
#include "app/interrupt.h"

#include <utility>  // Asio 1.74 lacks this include in C++20

#include <boost/asio/io_context.hpp>
#include <boost/asio/signal_set.hpp>
#include <csignal>
#include <thread>

namespace warpscope {

struct Interrupt::State {
  boost::asio::io_context context;
  boost::asio::signal_set signals{context, SIGINT, SIGTERM};
  std::stop_source source;
  std::jthread thread;
};

Interrupt::Interrupt() : state_(std::make_unique<State>()) {
  state_->signals.async_wait([state = state_.get()](const boost::system::error_code& error, int) {
    if (error) return;
    state->source.request_stop();
    state->signals.clear();  // a second signal has its usual effect
  });
  state_->thread = std::jthread([state = state_.get()] { state->context.run(); });
}

Interrupt::~Interrupt() { state_->context.stop(); }

std::stop_token Interrupt::token() const { return state_->source.get_token(); }

}  // namespace warpscope
