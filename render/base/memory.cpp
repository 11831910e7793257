// Reading what the kernel says.
// See memory.h.
#include "render/base/memory.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <charconv>
#include <fstream>
#include <limits>
#include <mutex>
#include <utility>
#include <vector>

#include "render/base/error.h"
#include "render/base/input_file.h"
#include "render/base/memory_limit.h"

namespace warpscope {
namespace {

namespace fs = std::filesystem;

/// The number that a file begins with; nothing where there is none, as in "max".
std::optional<uint64_t> numberIn(const fs::path& file) {
  std::ifstream stream(file);
  uint64_t number = 0;
  return stream >> number ? std::optional(number) : std::nullopt;
}

/// The number behind `key` in a file of lines "key number".
std::optional<uint64_t> numberBehind(const std::string& key, const fs::path& file) {
  std::ifstream stream(file);
  for (std::string line; std::getline(stream, line);)
    if (line.starts_with(key)) {
      const size_t at = line.find_first_of("0123456789", key.size());
      uint64_t number = 0;
      if (at != std::string::npos && std::from_chars(line.data() + at, line.data() + line.size(), number).ec == std::errc()) return number;
    }
  return std::nullopt;
}

struct GroupFiles {
  const char *limit, *used;
  std::array<const char*, 2> cached;  ///< keys of memory.stat
};
constexpr GroupFiles kVersion1{"memory.limit_in_bytes", "memory.usage_in_bytes", {"total_inactive_file ", "total_active_file "}};
constexpr GroupFiles kVersion2{"memory.max", "memory.current", {"inactive_file ", "active_file "}};

/// What `group`, a folder beneath `mount`, and those that it is in leave.
std::optional<uint64_t> leftInGroups(const fs::path& mount, const fs::path& group, const GroupFiles& names) {
  std::optional<uint64_t> least;
  for (fs::path at = group.relative_path();; at = at.parent_path()) {
    const fs::path folder = mount / at;
    const auto limit = numberIn(folder / names.limit), used = numberIn(folder / names.used);
    if (limit && used) {
      uint64_t kept = *used;
      for (const char* key : names.cached) kept -= std::min(kept, numberBehind(key, folder / "memory.stat").value_or(0));
      const uint64_t left = *limit - std::min(*limit, kept);
      least = std::min(least.value_or(left), left);
    }
    if (at.empty()) return least;
  }
}

}  // namespace

std::optional<uint64_t> availableMemoryBytes(const fs::path& root) {
  std::optional<uint64_t> least;
  const auto take = [&](std::optional<uint64_t> bytes) {
    if (bytes) least = std::min(least.value_or(*bytes), *bytes);
  };
  if (const auto kibibytes = numberBehind("MemAvailable:", root / "proc/meminfo")) take(*kibibytes * 1024);
  std::ifstream groups(root / "proc/self/cgroup");
  // Lines "0::/group" of version 2, "4:memory,other:/group" of version 1.
  for (std::string line; std::getline(groups, line);) {
    const size_t first = line.find(':'), second = line.find(':', first + 1);
    if (first == std::string::npos || second == std::string::npos) continue;
    const std::string controllers = "," + line.substr(first + 1, second - first - 1) + ",";
    const fs::path group = line.substr(second + 1);
    if (controllers == ",,") take(leftInGroups(root / "sys/fs/cgroup", group, kVersion2));
    if (controllers.find(",memory,") != std::string::npos) take(leftInGroups(root / "sys/fs/cgroup/memory", group, kVersion1));
  }
  return least;
}

namespace {

/// 0: none.
std::atomic<uint64_t> limitBytes = 0, deviceLimitBytes = 0;
std::atomic<int> sharers = 1;
std::optional<uint64_t> optionalOf(uint64_t bytes) { return bytes > 0 ? std::optional(bytes) : std::nullopt; }

/// Of the limit, a share is left free beside what comes in between two looks; and as much is used all the same.
constexpr uint64_t kShare = 6;

struct Droppables {
  std::mutex mutex;
  std::vector<Droppable*> all;
  std::atomic<uint64_t> bytesAtOnce = 0;  // of all threads
};
Droppables& droppables() {
  static Droppables known;
  return known;
}

/// statm, opened once: it is read for each ray.
class ResidentCount {
 public:
  ResidentCount() : file_(open("/proc/self/statm", O_RDONLY | O_CLOEXEC)) {}

  ResidentMemory now() const {
    char text[128];
    const ssize_t length = file_ >= 0 ? pread(file_, text, sizeof text, 0) : -1;
    uint64_t pages[3] = {};  // of all addresses; in memory; of these of files
    const char *at = text, *const end = text + std::max<ssize_t>(length, 0);
    for (uint64_t& count : pages) {
      while (at < end && *at == ' ') ++at;
      const auto [next, error] = std::from_chars(at, end, count);
      if (error != std::errc()) return {};
      at = next;
    }
    return {pages[1] * page_, (pages[1] - std::min(pages[1], pages[2])) * page_};
  }

 private:
  const int file_;
  const uint64_t page_ = static_cast<uint64_t>(sysconf(_SC_PAGESIZE));
};

}  // namespace

Droppable::Droppable(const void* memory, std::function<void()> drop, const BytesAtOnce& bytesAtOnce) : memory_(memory), drop_(std::move(drop)), bytesAtOnce_(bytesAtOnce(limitBytes)) {
  const std::scoped_lock lock(droppables().mutex);
  if (const uint64_t limit = limitBytes) {
    constexpr uint64_t kForPictures = uint64_t{64} << 20;
    const uint64_t resident = residentMemory().bytes;
    const auto neededBy = [&](uint64_t other) {
      constexpr uint64_t kMebibyte = uint64_t{1} << 20;
      const uint64_t needed = resident + droppables().bytesAtOnce + bytesAtOnce(other) + kForPictures;
      return (needed + needed / (kShare - 1) + kMebibyte - 1) / kMebibyte * kMebibyte;
    };
    if (uint64_t least = neededBy(limit); limit < least) {
      // More is brought in at once where there is more.
      for (uint64_t next; (next = neededBy(least)) > least;) least = next;
      throw InputError("the limit of " + sizeText(limit) + " of memory cannot be kept to: with what is looked at at once it takes " + sizeText(least));
    }
  }
  droppables().all.push_back(this);
  droppables().bytesAtOnce += bytesAtOnce_;
}

Droppable::~Droppable() {
  const std::scoped_lock lock(droppables().mutex);
  std::erase(droppables().all, this);
  droppables().bytesAtOnce -= bytesAtOnce_;
}

bool isDroppable(const void* memory) {
  const std::scoped_lock lock(droppables().mutex);
  return std::ranges::any_of(droppables().all, [&](const Droppable* one) { return one->memory_ == memory; });
}

namespace {
constexpr uint64_t kIsRoomForAll = 4, kOfLimit = 8;
}  // namespace

uint64_t limitForAll(uint64_t bytes) { return kIsRoomForAll * bytes; }

uint64_t limitedShare() { return limitBytes == 0 ? std::numeric_limits<uint64_t>::max() : limitBytes / kOfLimit; }

uint32_t slicesAtATime(uint64_t sliceBytes, uint32_t slices, uint64_t limit) {
  constexpr uint32_t kLeast = 8;  // a cell's two, and what gradients and long steps look at beside them
  if (limit == 0 || sliceBytes * slices <= limit / kIsRoomForAll) return slices;
  return static_cast<uint32_t>(std::min<uint64_t>(std::max<uint64_t>(limit / kOfLimit / sliceBytes, kLeast), slices));
}

void keepWithinMemoryLimit() {
  const uint64_t limit = limitBytes.load(std::memory_order_relaxed);
  if (limit == 0) return;
  const uint64_t share = limit / kShare, most = limit - share - std::min(droppables().bytesAtOnce.load(std::memory_order_relaxed), limit - 2 * share);
  if (residentMemory().bytes <= most) return;
  // Nobody goes on while another one is at it, which the system may let wait.
  const std::scoped_lock lock(droppables().mutex);
  if (residentMemory().bytes <= most) return;
  for (Droppable* const one : droppables().all) one->drop_();
}

ResidentMemory residentMemory() {
  static const ResidentCount count;
  return count.now();
}

void setMemoryLimit(std::optional<uint64_t> bytes) { limitBytes = bytes.value_or(0); }

std::optional<uint64_t> memoryLimit() { return optionalOf(limitBytes); }

void setDeviceMemoryLimit(std::optional<uint64_t> bytes) { deviceLimitBytes = bytes.value_or(0); }

std::optional<uint64_t> deviceMemoryLimit() { return optionalOf(deviceLimitBytes); }

void setDeviceSharers(int processes) { sharers = std::max(processes, 1); }

int deviceSharers() { return sharers; }

void requireMemory(uint64_t bytes, const std::string& what) {
  if (const std::optional<uint64_t> limit = memoryLimit()) {
    const uint64_t left = *limit - std::min(*limit, residentMemory().ownBytes);
    if (left < bytes) throw InputError(what + " needs " + sizeText(bytes) + " of memory, and of the " + sizeText(*limit) + " that it may have " + sizeText(left) + " are left");
  }
  const std::optional<uint64_t> free = availableMemoryBytes();
  if (free && *free < bytes)
    throw InputError(what + " needs " + sizeText(bytes) + " of memory, and " + sizeText(*free) + " are free; it does not fit into this machine's memory");
}

}  // namespace warpscope
