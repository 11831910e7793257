// Page-locked host memory, which a GPU copies to and from without the CPU's help. Free of CUDA itself.
// CUDA C++ Programming Guide, "Page-Locked Host Memory".
#pragma once

#include <memory_resource>

namespace warpscope::cuda {

/// Page-locked memory from a pool, because locking pages takes milliseconds: what is given back is kept for the next who asks. Lives as
/// long as the program. allocate() throws DeviceError. Safe to use from several threads.
std::pmr::memory_resource* pinnedMemory();

/// Unlocks what is kept and nobody uses: frames have become smaller, or nobody asks for any.
void giveBackPinnedMemory();

}  // namespace warpscope::cuda
