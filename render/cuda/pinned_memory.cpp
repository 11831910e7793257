// The pool: blocks of few sizes, those that are free in lists by size.
// See pinned_memory.h.
#include "render/cuda/pinned_memory.h"

#include <algorithm>
#include <bit>
#include <map>
#include <mutex>
#include <unordered_set>
#include <utility>
#include <vector>

#include "render/base/error.h"
#include "render/base/memory.h"
#include "render/cuda/check.h"

namespace warpscope::cuda {
namespace {

constexpr size_t kSmallestBlockBytes = size_t{1} << 16;
/// What is free beyond this is unlocked when somebody asks for more, locked pages being pages that others cannot have; or a sixteenth of what is free at first, where that is more: the segments of a
/// large frame are gigabytes, and locking them takes ten times as long as copying.
constexpr size_t kLeastKeptBytes = size_t{1} << 28, kKeptShare = 16;
size_t mostKeptBytes() { return std::max(kLeastKeptBytes, static_cast<size_t>(availableMemoryBytes().value_or(0)) / kKeptShare); }

class PinnedPool final : public std::pmr::memory_resource {
 public:
  ~PinnedPool() override { giveBack(); }  // may come after the driver's own end, which has freed them then

  void giveBack() { unlockAbove(0); }

 private:
  using Blocks = std::map<size_t, std::vector<void*>>;  // by their size

  /// Powers of two and three steps between them: at most a quarter more than was asked for.
  static size_t blockBytes(size_t bytes) {
    const size_t wanted = std::max(bytes, kSmallestBlockBytes), step = std::bit_floor(wanted) / 4;
    return (wanted + step - 1) / step * step;
  }

  /// Until no more bytes are kept, the largest blocks first.
  void unlockAbove(size_t most) {
    std::vector<void*> unused;
    {
      const std::scoped_lock lock(mutex_);
      while (keptBytes_ > most) {
        const auto largest = std::prev(free_.end());
        unused.push_back(largest->second.back());
        largest->second.pop_back();
        keptBytes_ -= largest->first;
        if (largest->second.empty()) free_.erase(largest);
      }
    }
    for (void* block : unused) cudaFreeHost(block);
  }

  void* do_allocate(size_t bytes, size_t) override {
    const size_t size = blockBytes(bytes);
    {
      const std::scoped_lock lock(mutex_);
      if (const auto blocks = free_.find(size); blocks != free_.end()) {
        void* block = blocks->second.back();
        blocks->second.pop_back();
        if (blocks->second.empty()) free_.erase(blocks);
        keptBytes_ -= size;
        return block;
      }
    }
    unlockAbove(mostKept_);
    void* block = nullptr;
    WARPSCOPE_CUDA_CHECK(cudaHostAlloc(&block, size, cudaHostAllocPortable));
    return block;
  }

  /// On any thread: unlocking, which takes milliseconds and may wait for the device, is for those who ask for more.
  void do_deallocate(void* block, size_t bytes, size_t) override {
    const size_t size = blockBytes(bytes);
    const std::scoped_lock lock(mutex_);
    free_[size].push_back(block);
    keptBytes_ += size;
  }

  bool do_is_equal(const std::pmr::memory_resource& other) const noexcept override { return this == &other; }

  std::mutex mutex_;
  Blocks free_;
  size_t keptBytes_ = 0;
  const size_t mostKept_ = mostKeptBytes();
};

class PinnedOrPlain final : public std::pmr::memory_resource {
 public:
  explicit PinnedOrPlain(std::pmr::memory_resource& pinned) : pinned_(pinned) {}

 private:
  void* do_allocate(size_t bytes, size_t alignment) override {
    try {
      return pinned_.allocate(bytes, alignment);
    } catch (const DeviceError&) {
      void* const block = std::pmr::new_delete_resource()->allocate(bytes, alignment);
      const std::scoped_lock lock(mutex_);
      plain_.insert(block);
      return block;
    }
  }
  void do_deallocate(void* block, size_t bytes, size_t alignment) override {
    const bool isPlain = [&] {
      const std::scoped_lock lock(mutex_);
      return plain_.erase(block) > 0;
    }();
    (isPlain ? *std::pmr::new_delete_resource() : pinned_).deallocate(block, bytes, alignment);
  }
  bool do_is_equal(const std::pmr::memory_resource& other) const noexcept override { return this == &other; }

  std::pmr::memory_resource& pinned_;
  std::mutex mutex_;
  std::unordered_set<void*> plain_;  // blocks that are not page-locked
};

PinnedPool& pinnedPool() {
  static PinnedPool pool;
  return pool;
}

}  // namespace

std::pmr::memory_resource* pinnedMemory() { return &pinnedPool(); }

std::pmr::memory_resource* pinnedOrPlainMemory() {
  static PinnedOrPlain memory(pinnedPool());
  return &memory;
}

void giveBackPinnedMemory() { pinnedPool().giveBack(); }

}  // namespace warpscope::cuda
