// Waiting for signals.
// See interrupt.h.
#include "app/shell/interrupt.h"

#include <utility>  // Asio 1.74 lacks this include in C++20

#include <atomic>
#include <boost/asio/io_context.hpp>
#include <boost/asio/signal_set.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <csignal>
#include <system_error>
#include <thread>
#include <vector>

#include "app/shell/log.h"
#include "render/base/error.h"

namespace warpscope {

namespace {

constexpr std::chrono::milliseconds kBounce(250);  // of a key
constexpr std::chrono::seconds kMoment(1);         // that ending may take without a word

std::atomic<bool> isInterrupted = false;

}  // namespace

struct Interrupt::State {
  boost::asio::io_context context;
  boost::asio::signal_set signals{context};
  boost::asio::steady_timer announcement{context};
  std::vector<int> numbers{SIGINT, SIGTERM};
  std::stop_source source;
  std::chrono::steady_clock::time_point firstAt;
  std::jthread thread;

  State() {
#if defined(SIGHUP)
    // What was started to outlive its terminal (nohup) ignores this one, and goes on doing so.
    struct sigaction current {};
    if (sigaction(SIGHUP, nullptr, &current) == 0 && current.sa_handler != SIG_IGN) numbers.push_back(SIGHUP);
#endif
    for (const int number : numbers) signals.add(number);
  }

  void wait() {
    signals.async_wait([this](const boost::system::error_code& error, int number) {
      if (error) return;
      const auto now = std::chrono::steady_clock::now();
      if (!source.stop_requested()) {
        firstAt = now;
        isInterrupted = true;
        source.request_stop();
        announcement.expires_after(kMoment);
        announcement.async_wait([](const boost::system::error_code& cancelled) {
          if (!cancelled) printLine("warpscope: stopping takes a while; press Ctrl-C again to end at once");
        });
      } else if (now - firstAt >= kBounce) {
        signals.clear();
        std::raise(number);  // its usual effect
      }
      wait();
    });
  }
};

Interrupt::Interrupt() {
  try {
    state_ = std::make_unique<State>();
    state_->wait();
    state_->thread = std::jthread([state = state_.get()] { state->context.run(); });
  } catch (const std::system_error& error) {
    throw InputError("interrupts cannot be listened for: " + error.code().message());
  } catch (const boost::system::system_error& error) {
    throw InputError("interrupts cannot be listened for: " + error.code().message());
  }
}

Interrupt::~Interrupt() {
  state_->context.stop();
  const bool isStopped = state_->source.stop_requested();
  const std::vector<int> numbers = state_->numbers;
  state_.reset();
  // The process is about to end by itself, and to say why.
  if (isStopped)
    for (const int number : numbers) std::signal(number, SIG_IGN);
}

std::stop_token Interrupt::token() const { return state_->source.get_token(); }

bool wasInterrupted() { return isInterrupted; }

}  // namespace warpscope
