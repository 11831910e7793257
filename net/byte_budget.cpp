// Two rows, one number.
// See byte_budget.h.
#include "net/byte_budget.h"

#include <stdexcept>
#include <string>

namespace warpscope::net {

/// Whoever takes so many bytes waits in this one.
std::deque<uint64_t>& ByteBudget::rowFor(size_t bytes) {
  if (bytes > largest())
    throw std::invalid_argument(std::to_string(bytes) + " bytes, where " + std::to_string(largest()) + " are the most");
  return rows_[isSmall(bytes) ? 1 : 0];
}

/// With the mutex held.
ByteBudget::SharePtr ByteBudget::give(size_t bytes) {
  taken_ += bytes;
  if (!isSmall(bytes)) takenByLarge_ += bytes;
  return std::make_shared<Share>(*this, bytes);
}

ByteBudget::SharePtr ByteBudget::take(size_t bytes, const std::stop_token& stop) {
  std::deque<uint64_t>& row = rowFor(bytes);
  SharePtr share;
  {
    std::unique_lock lock(mutex_);
    const uint64_t ticket = ++lastTicket_;
    row.push_back(ticket);
    changed_.wait(lock, stop, [&] { return row.front() == ticket && hasRoom(bytes); });
    std::erase(row, ticket);
    if (!stop.stop_requested()) share = give(bytes);
  }
  changed_.notify_all();  // there is another first one
  return share;
}

ByteBudget::SharePtr ByteBudget::tryTake(size_t bytes) {
  const std::deque<uint64_t>& row = rowFor(bytes);
  const std::scoped_lock lock(mutex_);
  return row.empty() && hasRoom(bytes) ? give(bytes) : nullptr;
}

bool ByteBudget::isShort() const {
  const std::scoped_lock lock(mutex_);
  return !rows_[0].empty() || !rows_[1].empty();
}

void ByteBudget::giveBack(size_t bytes, bool isSmall) {
  // Under the lock: who sees by taken() that all is back may end this at once.
  const std::scoped_lock lock(mutex_);
  taken_ -= bytes;
  if (!isSmall) takenByLarge_ -= bytes;
  changed_.notify_all();
}

size_t ByteBudget::taken() const {
  const std::scoped_lock lock(mutex_);
  return taken_;
}

void ByteBudget::Share::shrinkTo(size_t bytes) {
  if (bytes >= bytes_) return;
  budget_.giveBack(bytes_ - bytes, isSmall_);
  bytes_ = bytes;
}

}  // namespace warpscope::net
