// A process whose end is seen by another one, which started it and does nothing else: a signal that nobody can catch becomes a sentence and an exit code.
// Linux: fork(2), prctl(2), PR_SET_PDEATHSIG.
#pragma once

#include <optional>
#include <string>

namespace warpscope {

/// Goes on in a child of this process, where it returns nothing. In this one it waits until the child has ended, passes on to it what it is asked to do meanwhile (SIGINT, SIGTERM, SIGHUP, SIGQUIT,
/// SIGUSR1, SIGUSR2, and to stop and go on), and returns the code to end with: the child's own, or 1 where a signal has ended it, which it says in a line that begins with `self`, unless it
/// has passed it on as a wish that it end. The child never outlives this process. It is in a group of processes of its own, so that what a whole group is told comes to it once.
/// Returns nothing in this one too where no child can be started. Before any thread is.
std::optional<int> goOnInChild(const std::string& self);

}  // namespace warpscope
