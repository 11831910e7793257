// A thread that works on the newest job and leaves the newest result: each panel's warp, the reference, the scene loader.
// Jobs and results pass through Newest, so a slow worker skips jobs instead of falling behind.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <exception>
#include <functional>
#include <future>
#include <mutex>
#include <new>
#include <optional>
#include <stop_token>
#include <string>
#include <thread>

#include "render/base/error.h"
#include "render/base/newest.h"

namespace warpscope {

/// `Result` is default-constructible and has a member `std::string error`.
template <class Job, class Result>
class NewestWorker {
 public:
  /// Fills the result. May throw: OperationCancelled discards the result, any other exception's text becomes its error.
  using Work = std::function<void(const Job&, Result&, const std::stop_token&)>;

  /// `makeWork` is called on the worker's thread, and what it returns is destroyed there: the place for contexts that belong to a
  /// thread. `onResult` is called on the worker's thread after each result.
  NewestWorker(std::function<Work()> makeWork, std::function<void()> onResult)
      : onResult_(std::move(onResult)),
        thread_([this, make = std::move(makeWork)](const std::stop_token& stop) { run(make, stop); }) {}
  NewestWorker(const NewestWorker&) = delete;
  NewestWorker& operator=(const NewestWorker&) = delete;

  /// Replaces a job that has not begun.
  void post(Job job) { jobs_.put({std::move(job), epoch_.load()}); }

  std::optional<Result> tryTake() { return results_.tryTake(); }

  /// Ends the job at work, which leaves no result, and forgets the one that waits. A result that is there already stays.
  void cancel() {
    const std::scoped_lock lock(mutex_);
    ++epoch_;  // also reaches a job that was taken but has not begun
    atWork_.request_stop();
  }

  /// Cancels, and lets go of what is kept from one job to the next, by calling the work with a Job() that leaves no result; a result that nobody took goes as
  /// well. On the worker's thread, and whatever is cancelled later: for large things that are not needed any more.
  void forget() {
    cancel();
    forgets_ = true;
    jobs_.put({std::nullopt, epoch_.load()});
  }

  /// Asks the thread to end without waiting for it; the destructor waits.
  void requestStop() { thread_.request_stop(); }

  /// Waits until the thread has ended, but not beyond `time`. True if it has.
  bool waitForEnd(std::chrono::steady_clock::time_point time) const {
    return end_.wait_until(time) == std::future_status::ready;
  }

 private:
  struct Ticket {
    std::optional<Job> job;  ///< nothing: to wake up, because something is to be forgotten
    uint64_t epoch;
  };

  void run(const std::function<Work()>& makeWork, const std::stop_token& stop) {
    workOn(makeWork(), stop);
    ended_.set_value();
  }

  void workOn(const Work& work, const std::stop_token& stop) {
    while (true) {
      std::optional<Ticket> ticket = jobs_.take(stop);
      if (!ticket) return;
      if (forgets_.exchange(false)) {
        static_cast<void>(results_.tryTake());
        static_cast<void>(perform(work, Job(), {}));
      }
      if (!ticket->job) continue;
      std::stop_source source;
      {
        const std::scoped_lock lock(mutex_);
        if (ticket->epoch != epoch_) continue;
        atWork_ = source;
      }
      const std::stop_callback link(stop, [&] { source.request_stop(); });
      std::optional<Result> result = perform(work, *ticket->job, source.get_token());
      if (!result) continue;
      const uint64_t epoch = ticket->epoch;
      ticket.reset();  // what it holds may be large
      std::optional<Result> replaced;
      {
        const std::scoped_lock lock(mutex_);
        if (epoch != epoch_) continue;  // cancelled after its last look at the token
        replaced = results_.put(std::move(*result));
      }
      onResult_();
    }
  }

  static std::optional<Result> perform(const Work& work, const Job& job, const std::stop_token& stop) {
    std::optional<Result> result(std::in_place);
    try {
      work(job, *result, stop);
      if (stop.stop_requested()) return std::nullopt;
    } catch (const OperationCancelled&) {
      return std::nullopt;
    } catch (const std::bad_alloc&) {
      result->error = "there is not enough memory for this";
    } catch (const std::exception& error) {
      result->error = error.what();
    }
    return result;
  }

  const std::function<void()> onResult_;
  Newest<Ticket> jobs_;
  Newest<Result> results_;
  std::atomic<uint64_t> epoch_ = 0;  // how often cancel() was called
  std::atomic<bool> forgets_ = false;
  std::mutex mutex_;                 // of atWork_, and of the order in which epoch_ changes, jobs begin and results appear
  std::stop_source atWork_;
  std::promise<void> ended_;
  const std::shared_future<void> end_ = ended_.get_future().share();
  std::jthread thread_;  // last: it uses all of the above
};

}  // namespace warpscope
