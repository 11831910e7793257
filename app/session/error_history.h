// The error of one panel over the last seconds, as steps: a value holds from when it was measured until the next one, or until it is no longer true.
// Bounded: of more values than it has room for, the oldest go.
#pragma once

#include <algorithm>
#include <array>
#include <optional>
#include <vector>

#include "render/base/clock.h"

namespace warpscope {

class ErrorHistory {
 public:
  static constexpr std::chrono::seconds kSpan{10};
  static constexpr size_t kMost = 256;

  /// A value that holds from `begin` to `end`, seconds before now; 0 is now.
  struct Step {
    double beginS = 0.0;
    double endS = 0.0;
    double value = 0.0;
    bool isSparse = false;  ///< of few pixels of a picture that moved
  };

  /// `now` never goes back.
  void add(Clock::TimePoint now, double value, bool isSparse = false) { put({now, value, isSparse}); }

  /// What was added last is no longer true.
  void interrupt(Clock::TimePoint now) {
    if (count_ > 0 && last().value) put({now, std::nullopt, false});
  }

  /// Of the last kSpan, the oldest first.
  std::vector<Step> steps(Clock::TimePoint now) const {
    std::vector<Step> steps;
    const auto secondsAgo = [&](Clock::TimePoint time) { return std::chrono::duration<double>(now - time).count(); };
    const double span = std::chrono::duration<double>(kSpan).count();
    for (size_t i = count_ - std::min(count_, kMost); i < count_; ++i) {
      const Entry& entry = entries_[i % kMost];
      const double end = i + 1 < count_ ? secondsAgo(entries_[(i + 1) % kMost].time) : 0.0;
      if (entry.value && end < span) steps.push_back({std::min(secondsAgo(entry.time), span), end, *entry.value, entry.isSparse});
    }
    return steps;
  }

 private:
  struct Entry {
    Clock::TimePoint time{};
    std::optional<double> value;  ///< nothing: unknown from then on
    bool isSparse = false;
  };

  const Entry& last() const { return entries_[(count_ - 1) % kMost]; }
  void put(const Entry& entry) { entries_[count_++ % kMost] = entry; }

  std::array<Entry, kMost> entries_{};
  size_t count_ = 0;  // that were ever put
};

}  // namespace warpscope
