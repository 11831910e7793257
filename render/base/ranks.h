// Processes that work at one thing together: ranks, counted from 0, and messages between them. The words are MPI's (MPI Forum, MPI 4.0, chapters 3 and 6).
// What connects them is somebody else's: MPI, or threads of one process.
#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

namespace warpscope {

struct RankMessage {
  int from = 0;
  int kind = 0;  ///< what it is about, as sender and receiver agree; those below 0 are Ranks' own
  std::vector<std::byte> bytes;
};

/// One of several that divide something among themselves.
struct Sharer {
  size_t place = 0, count = 1;  ///< this one's among them
};

/// Which of `count` things are this one's, where all take about as many, in their order: [begin, end).
inline std::pair<size_t, size_t> shareOf(const Sharer& sharer, size_t count) {
  const auto before = [&](size_t place) { return count / sharer.count * place + count % sharer.count * place / sharer.count; };
  return {before(sharer.place), before(sharer.place + 1)};
}

/// This process's end. For one thread at a time, but for wake().
class Ranks {
 public:
  virtual ~Ranks() = default;

  virtual int rank() const = 0;
  virtual int size() const = 0;
  bool isFirst() const { return rank() == 0; }
  /// Whether it is on this machine, so that what is sent to it passes no network. Safe on any thread.
  virtual bool isNear(int /*other*/) const { return true; }

  /// Hands a message over, to itself as well; waits for nobody. Those from one rank to another arrive in the order in which they were sent.
  virtual void send(int to, int kind, std::vector<std::byte> bytes) = 0;
  /// Makes a receive() that waits return soon. Safe on any thread.
  virtual void wake() = 0;
  /// Ends all ranks at once, wherever they are; each process's exit code is `code`. Safe on any thread.
  [[noreturn]] virtual void abort(int code) = 0;

  /// The next message, whoever it is from; nothing after `atMost`, or when woken.
  std::optional<RankMessage> receive(std::chrono::microseconds atMost);

  /// Of a rank that is about to end all, because something is wrong: whether it is for this one to say what. The first rank always may, at once. Another one may if
  /// none has claimed it within `patience`, and of those that claim it together the lowest. `isToldToEnd`: it only ends because it was told to, which may be for what another one says,
  /// so that the first one waits as well. Messages that come meanwhile are thrown away.
  bool claimLastWord(std::chrono::milliseconds patience, bool isToldToEnd = false);

  // Of all ranks together: each calls the same, in the same order, and waits for the others. Other messages meanwhile are kept for receive().

  /// False: the others are busy with something else, and these calls throw std::logic_error instead of waiting for ever. At first true. While it is true, who says nothing for
  /// too long is not waited for, where what connects ranks can tell.
  virtual void setTogether(bool isTogether) { isTogether_ = isTogether; }
  bool isTogether() const { return isTogether_; }
  /// From when that is set on, who waits for others in these calls does not any more: they throw OperationCancelled. Whoever works at something long between them looks at it as well.
  void endWith(std::stop_token stop) { stop_ = std::move(stop); }
  const std::stop_token& stop() const { return stop_; }
  /// To be called with a sentence before abort() where work of all together has failed; at first nothing.
  void complainBy(std::function<void(const std::string&)> complain) { complain_ = std::move(complain); }
  void complain(const std::string& sentence) const {
    if (complain_) complain_(sentence);
  }

  /// What each has brought, by rank.
  std::vector<std::vector<std::byte>> allGather(std::span<const std::byte> own);
  /// The same of arrays that lie one behind the other: `own` is this rank's part of them all, and becomes them all.
  template <class T>
  void allGather(std::vector<T>& own) {
    std::vector<T> all;
    for (const std::vector<std::byte>& part : allGather(std::as_bytes(std::span<const T>(own)))) {
      const auto* const first = reinterpret_cast<const T*>(part.data());
      all.insert(all.end(), first, first + part.size() / sizeof(T));
    }
    own = std::move(all);
  }
  /// Throws InputError, on all of them, where `own` is not the same everywhere: "`what`: process 2 of 4 has another than the first one".
  void requireSame(std::span<const std::byte> own, const std::string& what);

  /// Which of `count` things are this rank's.
  std::pair<size_t, size_t> shareOf(size_t count) const { return warpscope::shareOf({static_cast<size_t>(rank()), static_cast<size_t>(size())}, count); }

 protected:
  /// As receive(), of what has not been received yet.
  virtual std::optional<RankMessage> receiveNew(std::chrono::microseconds atMost) = 0;

 private:
  enum Own { kGathered = -1, kDealt = -2, kLastWord = -3 };
  /// What the first of them has.
  std::vector<std::byte> ofFirst(std::vector<std::byte> own);
  RankMessage await(int kind, int from);
  /// As receiveNew(), of what is not kLastWord.
  std::optional<RankMessage> receiveOther(std::chrono::microseconds atMost);

  std::atomic<bool> isTogether_ = true;
  std::stop_token stop_;
  std::function<void(const std::string&)> complain_;
  int lastWordOf_ = std::numeric_limits<int>::max();  // the lowest that has claimed it
  std::deque<RankMessage> kept_;  // received before somebody asked for them
};

using RanksPtr = std::shared_ptr<Ranks>;

/// While it lives, all ranks do the same: Ranks::setTogether().
class Together {
 public:
  explicit Together(Ranks& ranks) : ranks_(ranks) { ranks_.setTogether(true); }
  ~Together() { ranks_.setTogether(false); }
  Together(const Together&) = delete;
  Together& operator=(const Together&) = delete;

 private:
  Ranks& ranks_;
};

/// Ranks::stop(), or nothing that is ever set where there are no ranks.
inline std::stop_token stopOf(const RanksPtr& ranks) { return ranks ? ranks->stop() : std::stop_token(); }

/// Ranks::shareOf(), or all of them where there are no ranks.
inline std::pair<size_t, size_t> shareOf(const RanksPtr& ranks, size_t count) { return ranks ? ranks->shareOf(count) : std::pair<size_t, size_t>{0, count}; }

/// As many ranks as there are ends, connected in this process: each end for a thread of its own. `areNear`: what isNear() says of others.
std::vector<RanksPtr> makeLocalRanks(int count, bool areNear = true);

}  // namespace warpscope
