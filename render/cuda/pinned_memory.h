// Page-locked host memory, which a GPU copies to and from without the CPU's help. Free of CUDA itself.
// CUDA C++ Programming Guide, "Page-Locked Host Memory".
#pragma once

#include <memory_resource>

namespace warpscope::cuda {

/// Page-locked memory from a pool, because locking pages takes milliseconds: what is given back, on any thread and at once, is kept for the next who asks. Lives as
/// long as the program. A block of more than 64 KiB is at most a quarter larger than was asked for. allocate() throws DeviceError. Safe to use from several threads.
std::pmr::memory_resource* pinnedMemory();

/// The same where there is some, else plain memory: for what only is quicker that way.
std::pmr::memory_resource* pinnedOrPlainMemory();

/// Unlocks what is kept and nobody uses: frames have become smaller, or nobody asks for any.
void giveBackPinnedMemory();

}  // namespace warpscope::cuda
