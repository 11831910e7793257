// Two rows, one number.
// See byte_budget.h.
#include "net/byte_budget.h"

#include <stdexcept>
#include <string>

namespace warpscope::net {

ByteBudget::SharePtr ByteBudget::take(size_t bytes, const std::stop_token& stop, std::chrono::milliseconds patience) {
  if (bytes > largest())
    throw std::invalid_argument(std::to_string(bytes) + " bytes, where " + std::to_string(largest()) + " are the most");
  const bool small = isSmall(bytes);
  std::unique_lock lock(mutex_);
  std::deque<uint64_t>& row = rows_[small ? 1 : 0];
  const uint64_t ticket = ++lastTicket_;
  row.push_back(ticket);
  const bool isTurn = changed_.wait_for(lock, stop, patience, [&] {
    return row.front() == ticket && taken_ + bytes <= bytes_ && (small || takenByLarge_ + bytes <= bytes_ / 2);
  });
  std::erase(row, ticket);
  const bool isGiven = isTurn && !stop.stop_requested();
  if (isGiven) {
    taken_ += bytes;
    if (!small) takenByLarge_ += bytes;
  }
  lock.unlock();
  changed_.notify_all();  // there is another first one
  return isGiven ? std::make_shared<Share>(*this, bytes) : nullptr;
}

void ByteBudget::giveBack(size_t bytes, bool isSmall) {
  {
    const std::scoped_lock lock(mutex_);
    taken_ -= bytes;
    if (!isSmall) takenByLarge_ -= bytes;
  }
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
