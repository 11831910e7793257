// Memory that answers take, from before they are made until they are sent, as a number of bytes that is never exceeded.
// Who needs more than is left waits, first come first served; what is small has a part of its own, so that it never waits for what is large.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <stop_token>

namespace warpscope::net {

/// Safe on any thread.
class ByteBudget {
 public:
  /// Half of `bytes` is for small needs alone: 1 / kSmallParts of it at most each.
  explicit ByteBudget(size_t bytes) : bytes_(bytes) {}

  static constexpr size_t kSmallParts = 128;
  /// The most that one need may be.
  size_t largest() const { return bytes_ / 16; }
  size_t bytes() const { return bytes_; }

  /// So many bytes, which are given back when it goes. The budget outlives it.
  class Share {
   public:
    Share(ByteBudget& budget, size_t bytes) : budget_(budget), bytes_(bytes), isSmall_(budget.isSmall(bytes)) {}
    ~Share() { budget_.giveBack(bytes_, isSmall_); }
    Share(const Share&) = delete;
    Share& operator=(const Share&) = delete;

    /// Gives back what is more than `bytes`.
    void shrinkTo(size_t bytes);
    size_t bytes() const { return bytes_; }

   private:
    ByteBudget& budget_;
    size_t bytes_;
    const bool isSmall_;  // from the beginning: whose part it is does not change
  };
  using SharePtr = std::shared_ptr<Share>;

  /// Waits until there are `bytes`, at most largest() (std::invalid_argument otherwise). Null once `stop` is set.
  SharePtr take(size_t bytes, const std::stop_token& stop);
  /// Null if there are none at once, or others wait for some.
  SharePtr tryTake(size_t bytes);

  /// Whether somebody waits.
  bool isShort() const;
  size_t taken() const;

 private:
  bool isSmall(size_t bytes) const { return bytes <= bytes_ / kSmallParts; }
  bool hasRoom(size_t bytes) const { return taken_ + bytes <= bytes_ && (isSmall(bytes) || takenByLarge_ + bytes <= bytes_ / 2); }
  std::deque<uint64_t>& rowFor(size_t bytes);
  SharePtr give(size_t bytes);
  void giveBack(size_t bytes, bool isSmall);

  const size_t bytes_;
  mutable std::mutex mutex_;
  std::condition_variable_any changed_;
  size_t taken_ = 0, takenByLarge_ = 0;
  std::deque<uint64_t> rows_[2];  // tickets of those that wait, large and small
  uint64_t lastTicket_ = 0;
};

}  // namespace warpscope::net
