// The processes that this one was started with, and what the first of them leads.
// MPI is a library beside the program (render/bricks/mpi_ranks.cpp), opened where a launcher of MPI's has started several processes.
#pragma once

#include <optional>

#include "render/base/ranks.h"
#include "render/bricks/brick_ranks.h"

namespace warpscope {

/// Where a launcher of MPI's has started several processes, goes on in a child of this one: shell/watched_process.h. Of a process that a signal has ended (SIGKILL, by whoever is
/// out of memory) launchers tell the signal; so all of its user's programs get 1 as of any other failure, and a sentence says which process it was. Before anything else.
std::optional<int> goOnWatched();

/// Finds out whether mpirun, or another launcher, has started several processes, and meets the others. Null where this one is alone. Once, before any thread is started.
/// Throws InputError where it was started so, but this build or machine has no MPI.
RanksPtr joinProcesses();

/// What joinProcesses() found.
const RanksPtr& processRanks();

/// On the first process: the leader of a volume that was opened with processRanks(), which marches its brick by `backend` (of the first call). Null for another.
BrickLeaderPtr leaderOf(const VolumePtr& volume, Backend backend = Backend::automatic);

/// On the others: does what the first one asks, to its end, its brick by `backend`. Ends all processes where `stop` is set and the first one goes on.
void followFirst(const VolumePtr& volume, Backend backend, const std::stop_token& stop);

/// Thrown when that end has come: nothing is left to do here.
struct FollowedToTheEnd {};

/// The first process lets the others go; waits for all to come to the same end, but no longer than for a moment after an interrupt: then this process ends with `code`.
void leaveProcesses(int code);

/// Ends all processes, each with `code`, and this one in any case.
[[noreturn]] void endProcesses(int code);

}  // namespace warpscope
