// How much memory this process may still take, and the refusal of more: asked before anything large is allocated, because Linux hands out more than
// there is and ends the process that uses it.
// Linux: proc(5), MemAvailable; cgroups(7), memory.max of version 2 and memory.limit_in_bytes of version 1.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

namespace warpscope {

/// The least of what the machine has left and what the control groups of this process leave it; memory that only caches files counts as free. Nothing
/// where the system does not say. `root` is where /proc and /sys are: another place in tests.
std::optional<uint64_t> availableMemoryBytes(const std::filesystem::path& root = "/");

/// Throws InputError, "`what` needs 3 TiB of memory, and 19.4 GiB are free", unless there is as much.
void requireMemory(uint64_t bytes, const std::string& what);

}  // namespace warpscope
