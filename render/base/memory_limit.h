// How much memory this process is to take at most, because somebody said so.
// Linux: proc(5), /proc/self/statm.
#pragma once

#include <cstdint>
#include <optional>

namespace warpscope {

/// What this process has in memory: all of it, and without what can be read of files again. Zeros where the system does not say.
struct ResidentMemory {
  uint64_t bytes = 0, ownBytes = 0;
};
ResidentMemory residentMemory();

/// How much this process is to have in memory at most, what it has read of mapped files included; nothing: as much as there is. Who maps files keeps to it (MappedFile).
/// To be set before anything large is.
void setMemoryLimit(std::optional<uint64_t> bytes);
std::optional<uint64_t> memoryLimit();

}  // namespace warpscope
