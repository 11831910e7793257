// When a rank's threads marched and when they waited, since a frame reached it: sums over slots of time, which widen as it takes longer.
// The same few bytes for any frame, so that ranks can tell each other.
#pragma once

#include <array>
#include <cstddef>
#include <type_traits>

namespace warpscope {

struct WorkTimeline {
  static constexpr size_t kSlots = 32;

  double slotMs = 0.25;                  ///< of each slot; the first begins when the frame reaches the rank
  std::array<float, kSlots> marchMs{};   ///< of all threads together, in each slot
  std::array<float, kSlots> waitMs{};    ///< likewise: for tiles

  /// A thread's time from `beginMs` to `endMs` since the frame began, 0 and more, into one of the two; what takes longer than the slots widens them.
  void addMarch(double beginMs, double endMs) { add(marchMs, beginMs, endMs); }
  void addWait(double beginMs, double endMs) { add(waitMs, beginMs, endMs); }
  /// How many threads' time there is in the slot where that is the most.
  double mostThreads() const;

 private:
  void add(std::array<float, kSlots>& slots, double beginMs, double endMs);
};
static_assert(std::is_trivially_copyable_v<WorkTimeline>);

}  // namespace warpscope
