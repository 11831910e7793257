// Mirrors io_thread.h.

#include "net/io_thread.h"

#include <exception>
#include <future>
#include <thread>

#include "net/timer.h"

namespace warpscope::net {

struct IoThread::State {
  Clock& clock;
  asio::io_context context{1};
  asio::executor_work_guard<asio::io_context::executor_type> work{asio::make_work_guard(context)};
  std::thread thread;

  explicit State(Clock& clockOfAll) : clock(clockOfAll) { setClock(context, clock); }

  void run() {
    // Coroutines deal with their own errors; one that escapes is a bug, but not a reason to stop serving the others.
    while (true) {
      try {
        context.run();
        return;
      } catch (const std::exception&) {
      }
    }
  }
};

IoThread::IoThread(Clock& clock) : state_(std::make_unique<State>(clock)) {
  state_->thread = std::thread([state = state_.get()] { state->run(); });
}

IoThread::~IoThread() {
  state_->work.reset();
  state_->context.stop();
  state_->thread.join();
}

asio::io_context& IoThread::context() { return state_->context; }

Clock& IoThread::clock() const { return state_->clock; }

void IoThread::callAndWait(const std::function<void()>& f) {
  std::packaged_task<void()> task(f);
  auto result = task.get_future();
  asio::post(state_->context, [&task] { task(); });
  result.get();
}

}  // namespace warpscope::net
