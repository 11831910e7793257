// Ranks that MPI started and connects. A library of its own, which the program opens where it was started as one of several processes: without MPI nothing
// of it is loaded.
// MPI 3.1: matched probes (Hoefler et al. 2010), sends that nobody waits for; one thread at a time makes its calls.
#include <mpi.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <climits>
#include <condition_variable>
#include <cstdlib>
#include <cstring>
#include <deque>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "render/base/error.h"
#include "render/base/ranks.h"

namespace warpscope {
namespace {

using namespace std::chrono_literals;

/// Kinds below 0 are messages as well; tags are not.
constexpr int kTagOfZero = 16;

/// Of messages that say nothing but that their sender is there, while all ranks are at something together and wait for one another: who
/// looks through gigabytes may take minutes, but who is stopped or has lost its machine is not to be waited for. Such messages go to the first rank, and from it to all.
constexpr int kAlive = -9;
constexpr std::chrono::seconds kAliveEvery = 2s, kSilence = 10s;
constexpr std::chrono::seconds kLastWait = 30s;  // for those that are in the middle of something, once there is nothing left to do

class MpiRanks final : public Ranks {
 public:
  MpiRanks() {
    int provided = 0;
    if (MPI_Init_thread(nullptr, nullptr, MPI_THREAD_SERIALIZED, &provided) != MPI_SUCCESS || provided < MPI_THREAD_SERIALIZED)
      throw InputError("MPI cannot be used by a program with several threads");
    MPI_Comm_rank(MPI_COMM_WORLD, &rank_);
    MPI_Comm_size(MPI_COMM_WORLD, &size_);
    // Machines are told apart by their names.
    constexpr size_t kLongestName = 256;
    std::vector<char> own(kLongestName), all(kLongestName * static_cast<size_t>(size_));
    gethostname(own.data(), kLongestName - 1);
    MPI_Allgather(own.data(), kLongestName, MPI_CHAR, all.data(), kLongestName, MPI_CHAR, MPI_COMM_WORLD);
    for (size_t other = 0; other < static_cast<size_t>(size_); ++other) isNear_.push_back(std::strcmp(own.data(), all.data() + kLongestName * other) == 0);
    silent_.resize(isNear_.size());
    attendant_ = std::jthread([this](const std::stop_token& stop) { attend(stop); });
  }
  ~MpiRanks() override {
    attendant_ = {};
    // What nobody wants any more is still received, on both sides, until all have come so far: a send that is not would keep MPI from its end.
    const auto end = std::chrono::steady_clock::now() + kLastWait;
    const auto lookAgain = [&] {
      look();
      std::this_thread::sleep_for(kShortest);
      if (std::chrono::steady_clock::now() < end) return;
      complain("the other processes do not come to an end");
      abort(1);
    };
    while (!sending_.empty()) lookAgain();
    MPI_Request all{};
    MPI_Ibarrier(MPI_COMM_WORLD, &all);
    while (test(all) == 0) lookAgain();
    MPI_Finalize();
  }

  void setTogether(bool isTogether) override {
    Ranks::setTogether(isTogether);
    std::ranges::fill(silent_, std::chrono::steady_clock::duration());
    hasSent_.notify_one();  // the attendant, which says that this process is there
  }

  int rank() const override { return rank_; }
  int size() const override { return size_; }
  bool isNear(int other) const override { return isNear_[static_cast<size_t>(other)]; }
  void send(int to, int kind, std::vector<std::byte> bytes) override {
    if (bytes.size() > INT_MAX) throw InputError("a message between processes of " + std::to_string(bytes.size()) + " bytes is longer than MPI takes");
    const std::scoped_lock lock(calls_);
    Sent& sent = sending_.emplace_back();
    sent.bytes = std::move(bytes);
    MPI_Isend(sent.bytes.data(), static_cast<int>(sent.bytes.size()), MPI_BYTE, to, kind + kTagOfZero, MPI_COMM_WORLD, &sent.request);
    hasSent_.notify_one();
  }
  void wake() override {
    const std::scoped_lock lock(mutex_);
    isWoken_ = true;
    woken_.notify_one();
  }
  void abort(int code) override {
    // Another thread may be in a call of MPI's, which only takes long if it hangs.
    for (int tries = 0; tries < 200 && !calls_.try_lock(); ++tries) std::this_thread::sleep_for(1ms);
    MPI_Abort(MPI_COMM_WORLD, code);
    std::_Exit(code);
  }

 private:
  /// Between looks, as long as nothing comes: longer once nothing has been on its way for a while. MPI's own waiting keeps a core busy, which other ranks may need; but what is
  /// on its way moves on only while both sides look, a part of a message each time.
  static constexpr std::chrono::microseconds kShortest = 20us, kLongest = 500us, kStillBusy = 10ms;

  /// As long as a message that has begun to come is waited for at a time, without a pause.
  static constexpr std::chrono::milliseconds kReceiving = 5ms;

  /// As long as nobody has to look for the attendant to do it.
  static constexpr std::chrono::milliseconds kUnseen = 5ms;

  struct Receiving {
    RankMessage message;
    MPI_Request request{};
  };

  struct Sent {
    std::vector<std::byte> bytes;
    MPI_Request request{};
  };

  std::optional<RankMessage> receiveNew(std::chrono::microseconds atMost) override {
    auto last = std::chrono::steady_clock::now();
    const auto end = last + atMost;
    for (std::chrono::microseconds pause = kShortest;; pause = std::min(2 * pause, kLongest)) {
      if (std::optional<RankMessage> message = look()) {
        lastMoved_ = std::chrono::steady_clock::now();
        return message;
      }
      const auto now = std::chrono::steady_clock::now();
      noteSilence(std::min<std::chrono::steady_clock::duration>(now - std::exchange(last, now), kAliveEvery));  // all may have been stopped together
      if (isSending() || std::chrono::steady_clock::now() - lastMoved_ < kStillBusy) pause = kShortest;
      std::unique_lock lock(mutex_);
      woken_.wait_for(lock, pause, [&] { return isWoken_; });
      if (std::exchange(isWoken_, false) || std::chrono::steady_clock::now() >= end) return {};
    }
  }

  bool isSending() {
    const std::scoped_lock lock(calls_);
    return !sending_.empty();
  }

  std::optional<RankMessage> look() {
    lastLook_ = std::chrono::steady_clock::now();
    dropSent();
    const std::scoped_lock lock(calls_);
    for (;;) {
      if (!receiving_ && !beginReceiving()) return {};
      // A long message needs its sender to the end, who may be gone: MPI's own waiting would be for ever.
      for (const auto end = std::chrono::steady_clock::now() + kReceiving; test(receiving_->request) == 0; std::this_thread::yield())
        if (std::chrono::steady_clock::now() > end) return {};
      RankMessage message = std::move(receiving_->message);
      receiving_.reset();
      silent_[static_cast<size_t>(message.from)] = {};
      if (message.kind != kAlive) return message;
    }
  }

  /// Of the next message, if there is one, what has come, into receiving_; the rest follows. For who has calls_.
  bool beginReceiving() {
    int isThere = 0;
    MPI_Message found{};
    MPI_Status status{};
    MPI_Improbe(MPI_ANY_SOURCE, MPI_ANY_TAG, MPI_COMM_WORLD, &isThere, &found, &status);
    if (isThere == 0) return false;
    int size = 0;
    MPI_Get_count(&status, MPI_BYTE, &size);
    receiving_.emplace();
    receiving_->message = {status.MPI_SOURCE, status.MPI_TAG - kTagOfZero, std::vector<std::byte>(static_cast<size_t>(size))};
    MPI_Imrecv(receiving_->message.bytes.data(), size, MPI_BYTE, &found, &receiving_->request);
    return true;
  }

  static int test(MPI_Request& request) {
    int isDone = 0;
    MPI_Test(&request, &isDone, MPI_STATUS_IGNORE);
    return isDone;
  }

  /// Beside whoever receives: while all are together, says that this process is there; and moves on what has been sent where nobody looks for long, because he is at something else
  /// or has nothing to wait for. Else others wait for the rest of it, a core busy each.
  void attend(const std::stop_token& stop) {
    std::chrono::steady_clock::time_point saidAlive;
    while (!stop.stop_requested()) {
      const auto now = std::chrono::steady_clock::now();
      if (isTogether() && now - saidAlive >= kAliveEvery) {
        saidAlive = now;
        for (int other = 0; other < size_; ++other)
          if (other != rank_ && (rank_ == 0 || other == 0)) send(other, kAlive, {});
      }
      const bool isLookedAfter = now - lastLook_.load() < kUnseen;
      if (!isLookedAfter) dropSent();
      const bool wasTogether = isTogether();
      std::unique_lock lock(calls_);
      if (sending_.empty()) {
        hasSent_.wait_for(lock, stop, kAliveEvery, [&] { return !sending_.empty() || isTogether() != wasTogether; });
      } else {
        lock.unlock();
        std::this_thread::sleep_for(isLookedAfter ? kUnseen : kShortest);
      }
    }
  }

  /// So much longer has been waited, and nothing has come. Throws InputError where somebody has said nothing for too long; then all begins anew.
  void noteSilence(std::chrono::steady_clock::duration waited) {
    if (!isTogether()) return;
    for (int other = 0; other < size_; ++other) {
      if (other == rank_ || (rank_ != 0 && other != 0) || (silent_[static_cast<size_t>(other)] += waited) < kSilence + underWayFrom(other)) continue;
      setTogether(true);
      throw InputError("process " + std::to_string(other) + " of " + std::to_string(size_) + " does not answer");
    }
  }

  /// What a message that has begun to come may take, over a slow network: nothing else is heard of its sender meanwhile.
  std::chrono::seconds underWayFrom(int other) const {
    constexpr size_t kLeastRate = 4 << 20;  // bytes a second
    return std::chrono::seconds(receiving_ && receiving_->message.from == other ? receiving_->message.bytes.size() / kLeastRate : 0);
  }

  void dropSent() {
    const std::scoped_lock lock(calls_);
    // In their order, as far as they are done: of thousands that a slow rank keeps waiting not each is asked after each time.
    for (; !sending_.empty(); sending_.pop_front())
      if (test(sending_.front().request) == 0) return;
  }

  int rank_ = 0, size_ = 1;
  std::vector<bool> isNear_;  // by rank
  std::vector<std::chrono::steady_clock::duration> silent_;  // by rank: how long has been waited since one has said something. Of receivers
  std::chrono::steady_clock::time_point lastMoved_;  // of receivers
  std::atomic<std::chrono::steady_clock::time_point> lastLook_{};
  std::mutex calls_;  // of MPI, but for the last
  std::condition_variable_any hasSent_;  // with it
  std::deque<Sent> sending_;
  std::optional<Receiving> receiving_;  // the message that comes first; those behind it wait
  std::mutex mutex_;  // of what follows
  std::condition_variable woken_;
  bool isWoken_ = false;
  std::jthread attendant_;
};

}  // namespace
}  // namespace warpscope

/// The processes that were started with this one, for the caller to delete; null, with a sentence in `reason`, where MPI cannot be used. Once a process.
extern "C" __attribute__((visibility("default"))) warpscope::Ranks* warpscopeMpiRanks(std::string* reason) {
  try {
    return new warpscope::MpiRanks;
  } catch (const std::exception& error) {
    *reason = error.what();
    return nullptr;
  }
}
