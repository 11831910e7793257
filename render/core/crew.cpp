// One job at a time, which every thread takes part in.
// See crew.h.
#include "render/core/crew.h"

#include <sys/resource.h>
#include <tbb/task_arena.h>
#include <unistd.h>

#include <algorithm>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

namespace warpscope {
namespace {

thread_local Crew* crewOfThisThread = nullptr;
thread_local bool thisThreadStandsBack = false;

std::mutex breakMutex;
std::condition_variable breakEnded;

}  // namespace

Crew::Shift::Shift(Crew* crew) : before_(std::exchange(crewOfThisThread, crew)) {}
Crew::Shift::~Shift() { crewOfThisThread = before_; }
Crew* Crew::ofThisThread() { return crewOfThisThread; }

Crew::Break::Break() { ++breaks_; }
Crew::Break::~Break() {
  {
    const std::scoped_lock lock(breakMutex);
    --breaks_;
  }
  breakEnded.notify_all();
}
void Crew::waitForBreaks() {
  if (!thisThreadStandsBack) return;
  std::unique_lock lock(breakMutex);
  breakEnded.wait_for(lock, kMostPause, [] { return breaks_.load() == 0; });
}

void Crew::standBack(int nice) {
  thisThreadStandsBack = true;
  // Where the system refuses, the thread stays as it is: it works as well, and others wait for it.
  const auto first = static_cast<id_t>(getpid()), self = static_cast<id_t>(gettid());
  setpriority(PRIO_PROCESS, self, std::max(getpriority(PRIO_PROCESS, self), getpriority(PRIO_PROCESS, first) + nice));
}

bool Crew::doesThisThreadStandBack() { return thisThreadStandsBack; }

struct Crew::State {
  ~State() {
    {
      const std::scoped_lock lock(mutex);
      isEnding = true;
    }
    changed.notify_all();
    threads.clear();  // also where only some could be started
  }

  void work(int nice) {
    standBack(nice);
    std::unique_lock lock(mutex);
    for (size_t done = 0;;) {
      changed.wait(lock, [&] { return isEnding || job > done; });
      if (isEnding) return;
      done = job;
      lock.unlock();
      std::exception_ptr thrown;
      try {
        (*body)();
      } catch (...) {
        thrown = std::current_exception();
      }
      lock.lock();
      if (thrown && !failure) failure = thrown;
      if (--atWork == 0) changed.notify_all();
    }
  }

  std::mutex running;  // of one caller
  std::mutex mutex;    // of the following
  std::condition_variable changed;
  const std::function<void()>* body = nullptr;
  size_t job = 0;  // how many there have been
  size_t atWork = 0;
  bool isEnding = false;
  std::exception_ptr failure;
  std::vector<std::jthread> threads;
};

size_t Crew::usualSize() { return static_cast<size_t>(std::max(1, tbb::this_task_arena::max_concurrency())); }

Crew::Crew(size_t threads, int nice) : state_(std::make_unique<State>()) {
  if (threads == 0) threads = usualSize();
  for (size_t i = 0; i < threads; ++i) state_->threads.emplace_back([state = state_.get(), nice] { state->work(nice); });
}

Crew::~Crew() = default;

size_t Crew::size() const { return state_->threads.size(); }

void Crew::run(const std::function<void()>& body) {
  const std::scoped_lock one(state_->running);
  std::unique_lock lock(state_->mutex);
  state_->body = &body;
  state_->atWork = state_->threads.size();
  ++state_->job;
  state_->changed.notify_all();
  state_->changed.wait(lock, [&] { return state_->atWork == 0; });
  state_->body = nullptr;
  if (const std::exception_ptr failure = std::exchange(state_->failure, nullptr)) std::rethrow_exception(failure);
}

}  // namespace warpscope
