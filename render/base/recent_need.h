// When memory that is kept for the next use has become too much: buffers that grew for one large frame are not to stay for good.
// The rule is the same everywhere: what none of the last kUses uses needed is given back.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>

namespace warpscope {

/// Of one user of buffers, which calls exceedsRecent() after each use.
class RecentNeed {
 public:
  static constexpr size_t kUses = 16;
  /// Buffers that are no more than so many times too large may stay: sizes vary a little.
  static constexpr size_t kSlack = 2;

  /// Notes a use that needed so much, in any unit. True if what is kept for an earlier use is more than kSlack times what each of the last
  /// kUses needed: then the buffers are to be given back, all of them, and whoever asked does so.
  bool exceedsRecent(size_t need) {
    recent_[next_++ % kUses] = need;
    kept_ = std::max(kept_, need);
    const size_t most = *std::max_element(recent_.begin(), recent_.end());
    if (next_ < kUses || kept_ / kSlack <= most) return false;
    kept_ = 0;
    return true;
  }

 private:
  std::array<size_t, kUses> recent_{};
  size_t next_ = 0;
  size_t kept_ = 0;  // the most that was needed since all was given back
};

}  // namespace warpscope
