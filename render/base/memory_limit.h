// How much memory this process is to take at most, because somebody said so.
// Linux: proc(5), /proc/self/statm.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>

namespace warpscope {

/// What this process has in memory: all of it, and without what can be read of files again. Zeros where the system does not say.
struct ResidentMemory {
  uint64_t bytes = 0, ownBytes = 0;
};
ResidentMemory residentMemory();

/// How much this process is to have in memory at most, what it has read of mapped files included; nothing: as much as there is. To be set before anything large is.
void setMemoryLimit(std::optional<uint64_t> bytes);
std::optional<uint64_t> memoryLimit();

/// The same of a device's memory, for a volume.
void setDeviceMemoryLimit(std::optional<uint64_t> bytes);
std::optional<uint64_t> deviceMemoryLimit();
/// Processes that have this one's device together, itself included; at first 1. To be set likewise.
void setDeviceSharers(int processes);
int deviceSharers();

/// Something that can let go of memory, and get it again where it is needed: a mapped file. While there is one, keepWithinMemoryLimit() may call it, on any thread.
class Droppable {
 public:
  /// What all threads may bring in between two calls of keepWithinMemoryLimit(), where that is the limit (0: there is none).
  using BytesAtOnce = std::function<uint64_t(uint64_t limit)>;

  /// `memory`: where it begins. Throws InputError, which says how much would do, where the limit cannot be kept to.
  Droppable(const void* memory, std::function<void()> drop, const BytesAtOnce& bytesAtOnce);
  ~Droppable();
  Droppable(const Droppable&) = delete;
  Droppable& operator=(const Droppable&) = delete;

 private:
  friend void keepWithinMemoryLimit();
  friend bool isDroppable(const void* memory);
  const void* const memory_;
  const std::function<void()> drop_;
  const uint64_t bytesAtOnce_;
};

/// Whether what begins there is a Droppable's. Safe on any thread.
bool isDroppable(const void* memory);

/// Of a droppable volume's slices, to how many whoever looks at all of them keeps at a time, so that the limit can be kept to: all where there is no limit (0), or room for them.
uint32_t slicesAtATime(uint64_t sliceBytes, uint32_t slices, uint64_t limit);
inline uint32_t slicesAtATime(uint64_t sliceBytes, uint32_t slices) { return slicesAtATime(sliceBytes, slices, memoryLimit().value_or(0)); }
/// As much of the limit, for what else grows with the picture and can be had in parts: of rays under way what they have gathered. As much as there is without one.
uint64_t limitedShare();

/// The least limit under which that is all of them.
uint64_t limitForAll(uint64_t bytes);

/// Lets go of what can be dropped if the process has come near its limit. For those who read mapped files, now and then: a fault maps up to 2 MiB, so that who looks here and
/// there brings in gigabytes within milliseconds, and a thread that watched would come too late. A microsecond where there is a limit, nothing where there is none.
void keepWithinMemoryLimit();

}  // namespace warpscope
