// Who may march now, where several want to: one or a few at a time, a slice of time each, in the order in which they asked.
// A ticket lock (Mellor-Crummey, Scott 1991) whose tickets can be handed back; slices as in round-robin scheduling (Kleinrock 1964).
#pragma once

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <deque>
#include <memory>
#include <mutex>
#include <stop_token>

#include "render/base/error.h"

namespace warpscope {

/// A march that would take longer than it may.
class WorkLimitExceeded : public InputError {
 public:
  /// `share`: how much of it, 0..1, would have fitted, as far as can be told.
  WorkLimitExceeded(std::chrono::nanoseconds limit, double share);

  std::chrono::nanoseconds limit() const { return limit_; }
  double share() const { return share_; }

 private:
  std::chrono::nanoseconds limit_;
  double share_;
};

struct TurnSettings {
  std::chrono::nanoseconds slice = std::chrono::milliseconds(8);  ///< of one turn; what is begun within it is finished
  std::chrono::nanoseconds limit{0};                              ///< of all turns of a job together; 0 is none
};

/// Safe on any thread.
class Turns {
 public:
  explicit Turns(TurnSettings settings = {}) : settings_(settings), row_(std::make_shared<Row>()) {}
  /// Another one of the same row: turns of both count together.
  std::shared_ptr<Turns> sibling() const { return std::shared_ptr<Turns>(new Turns(settings_, row_)); }

  /// Ends when it goes.
  class Turn {
   public:
    explicit Turn(Turns& turns) : turns_(turns) {}
    ~Turn() { turns_.end(); }
    /// How many there are at this moment.
    int atOnce() const { return turns_.taken(); }
    Turn(const Turn&) = delete;
    Turn& operator=(const Turn&) = delete;

   private:
    Turns& turns_;
  };

  /// Waits for it. Throws OperationCancelled if `stop` is set first.
  Turn take(const std::stop_token& stop);

  /// How many turns there may be at the same time, of the whole row; at first 1. Those that there are go on.
  void setAtOnce(int most);

  const TurnSettings& settings() const { return settings_; }
  /// Jobs that wait for a turn.
  size_t waiting() const;
  /// How long take() has waited by this one since the last call.
  std::chrono::nanoseconds exchangeWaited() { return std::chrono::nanoseconds(waitedNs_.exchange(0)); }

 private:
  /// Who waits is woken alone, when it is the first: with one condition for all each turn would wake as many threads as there are jobs.
  struct Ticket {
    std::condition_variable_any changed;
  };
  struct Row {
    std::mutex mutex;
    int atOnce = 1;
    std::deque<Ticket*> tickets;  // of those that wait, the first one first
    int taken = 0;

    /// Under the mutex, so that the ticket is there as long as that takes.
    void wakeFirst() {
      if (taken < atOnce && !tickets.empty()) tickets.front()->changed.notify_one();
    }
  };

  Turns(TurnSettings settings, std::shared_ptr<Row> row) : settings_(settings), row_(std::move(row)) {}
  void end();
  int taken() const;

  const TurnSettings settings_;
  const std::shared_ptr<Row> row_;
  std::atomic<int64_t> waitedNs_ = 0;
};

using TurnsPtr = std::shared_ptr<Turns>;

/// What one job has used of its time: of turns at the same time its share. Without turns it may go on.
class TurnsOfJob {
 public:
  /// `turns` may be null, and outlives this.
  explicit TurnsOfJob(Turns* turns) : turns_(turns) {}

  bool areLimited() const { return turns_ != nullptr; }

  /// Calls work(end) in a turn, which should return soon after `end`; true once it says that all is done. `done`: what share of the job is
  /// done after that, 0..1. Throws OperationCancelled, or WorkLimitExceeded where the job takes, or clearly will take, longer than it may.
  template <class Work, class Done>
  bool work(const std::stop_token& stop, const Work& work, const Done& done) {
    bool isDone;
    {
      const Turns::Turn turn = turns_->take(stop);
      const auto begin = std::chrono::steady_clock::now();
      const int atBegin = turn.atOnce();
      isDone = work(begin + turns_->settings().slice);
      used_ += (std::chrono::steady_clock::now() - begin) / std::max(atBegin, turn.atOnce());
    }
    if (!isDone) requireTime(done());
    return isDone;
  }

 private:
  void requireTime(double done) const;

  Turns* turns_;
  std::chrono::nanoseconds used_{0};
};

}  // namespace warpscope
