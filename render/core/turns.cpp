// Tickets, and what is left of a job's time.
// See turns.h.
#include "render/core/turns.h"

#include <algorithm>
#include <cstdio>
#include <string>

namespace warpscope {
namespace {

// A job is given up early where a part of its time shows that it would take several times as long as it may: parts of pictures differ.
constexpr double kTellingShare = 1.0 / 8;
constexpr double kClearlyTooLong = 4.0;

std::string limitText(std::chrono::nanoseconds limit, double share) {
  char text[160];
  std::snprintf(text, sizeof text, "it takes more than the %.3g s that one request may take: %.2g %% of it would fit",
                std::chrono::duration<double>(limit).count(), 100.0 * share);
  return text;
}

}  // namespace

WorkLimitExceeded::WorkLimitExceeded(std::chrono::nanoseconds limit, double share)
    : InputError(limitText(limit, share)), limit_(limit), share_(share) {}

Turns::Turn Turns::take(const std::stop_token& stop) {
  const auto begin = std::chrono::steady_clock::now();
  Row& row = *row_;
  std::unique_lock lock(row.mutex);
  Ticket ticket;
  row.tickets.push_back(&ticket);
  ticket.changed.wait(lock, stop, [&] { return row.taken < row.atOnce && row.tickets.front() == &ticket; });
  std::erase(row.tickets, &ticket);
  if (stop.stop_requested()) {
    row.wakeFirst();  // another may be it now
    throw OperationCancelled();
  }
  ++row.taken;
  row.wakeFirst();  // who has been first meanwhile was told while this one still stood before it
  lock.unlock();
  waitedNs_ += std::chrono::nanoseconds(std::chrono::steady_clock::now() - begin).count();
  return Turn(*this);
}

void Turns::end() {
  const std::scoped_lock lock(row_->mutex);
  --row_->taken;
  row_->wakeFirst();
}

int Turns::taken() const {
  const std::scoped_lock lock(row_->mutex);
  return row_->taken;
}

void Turns::setAtOnce(int most) {
  const std::scoped_lock lock(row_->mutex);
  row_->atOnce = std::max(most, 1);
  row_->wakeFirst();
}

size_t Turns::waiting() const {
  const std::scoped_lock lock(row_->mutex);
  return row_->tickets.size();
}

void TurnsOfJob::requireTime(double done) const {
  const std::chrono::nanoseconds limit = turns_->settings().limit;
  if (limit.count() <= 0) return;
  const double usedShare = std::chrono::duration<double>(used_) / std::chrono::duration<double>(limit);
  const double fitting = done / std::max(usedShare, 1e-12);  // of the job, if the rest is as the part so far
  if (usedShare >= 1.0 || (usedShare >= kTellingShare && fitting * kClearlyTooLong < 1.0))
    throw WorkLimitExceeded(limit, std::min(fitting, 1.0));
}

}  // namespace warpscope
