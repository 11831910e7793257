// When whoever wants the cores for a short while (Crew::Break) will want them next, for what cannot pause half way.
#pragma once

#include <chrono>

namespace warpscope {

/// Somebody's next break will begin about then. Until another is expected; it may never come.
void expectBreak(std::chrono::steady_clock::time_point begin);

/// What takes longer is begun all the same, with as much time as this before the next break.
inline constexpr std::chrono::milliseconds kMostTimeBeforeBreak{6};

/// Returns at once if what takes so long, begun now, ends before the next break, and when that has ended else. Waits little longer than kMostTimeBeforeBreak and Crew::kMostPause.
/// Threads that do not stand back are not held up.
void leaveBreakAlone(std::chrono::duration<double, std::milli> length);

}  // namespace warpscope
