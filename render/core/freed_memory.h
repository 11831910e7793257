// What was freed, as the system sees it.
#pragma once

namespace warpscope {

/// Lets the system have the pages of what was freed, where the library would keep them. Takes milliseconds, in which other threads that want memory have to wait: for rare events, and not
/// in a break (expected_break.h).
void giveBackFreedMemory();

}  // namespace warpscope
