// By the time that is told, without a word from the break itself.
// See expected_break.h.
#include "render/core/expected_break.h"

#include <algorithm>
#include <atomic>
#include <thread>

#include "render/core/crew.h"

namespace warpscope {
namespace {

using SteadyClock = std::chrono::steady_clock;

/// Breaks begin a little later than they are expected.
constexpr std::chrono::microseconds kLateness{500};

std::atomic<SteadyClock::time_point> expected{};

}  // namespace

void expectBreak(SteadyClock::time_point begin) { expected = begin; }

void leaveBreakAlone(std::chrono::duration<double, std::milli> length) {
  if (!Crew::doesThisThreadStandBack()) return;
  const SteadyClock::time_point begin = expected, now = SteadyClock::now();
  if (begin > now && begin - now < std::min<std::chrono::duration<double, std::milli>>(length, kMostTimeBeforeBreak)) std::this_thread::sleep_until(begin + kLateness);
  Crew::pauseForBreaks();
}

}  // namespace warpscope
