// The pool: blocks of powers of two, those that are free in lists by size.
// See pinned_memory.h.
#include "render/cuda/pinned_memory.h"

#include <algorithm>
#include <array>
#include <bit>
#include <mutex>
#include <vector>

#include "render/base/memory.h"
#include "render/cuda/check.h"

namespace warpscope::cuda {
namespace {

constexpr size_t kSmallestBlockBytes = size_t{1} << 16;
/// More than this is not kept, locked pages being pages that others cannot have; or a sixteenth of what is free at first, where that is more: the segments of a
/// large frame are gigabytes, and locking them takes ten times as long as copying.
constexpr size_t kLeastKeptBytes = size_t{1} << 28, kKeptShare = 16;
size_t mostKeptBytes() { return std::max(kLeastKeptBytes, static_cast<size_t>(availableMemoryBytes().value_or(0)) / kKeptShare); }

class PinnedPool final : public std::pmr::memory_resource {
 public:
  ~PinnedPool() override { giveBack(); }  // may come after the driver's own end, which has freed them then

  void giveBack() {
    std::array<std::vector<void*>, 64> unused;
    {
      const std::scoped_lock lock(mutex_);
      unused.swap(free_);
      keptBytes_ = 0;
    }
    for (const std::vector<void*>& blocks : unused)
      for (void* block : blocks) cudaFreeHost(block);
  }

 private:
  static size_t blockBytes(size_t bytes) { return std::bit_ceil(bytes < kSmallestBlockBytes ? kSmallestBlockBytes : bytes); }

  void* do_allocate(size_t bytes, size_t) override {
    const size_t size = blockBytes(bytes);
    {
      const std::scoped_lock lock(mutex_);
      std::vector<void*>& blocks = free_[static_cast<size_t>(std::countr_zero(size))];
      if (!blocks.empty()) {
        void* block = blocks.back();
        blocks.pop_back();
        keptBytes_ -= size;
        return block;
      }
    }
    void* block = nullptr;
    WARPSCOPE_CUDA_CHECK(cudaHostAlloc(&block, size, cudaHostAllocPortable));
    return block;
  }

  void do_deallocate(void* block, size_t bytes, size_t) override {
    const size_t size = blockBytes(bytes);
    {
      const std::scoped_lock lock(mutex_);
      if (keptBytes_ + size <= mostKept_) {
        free_[static_cast<size_t>(std::countr_zero(size))].push_back(block);
        keptBytes_ += size;
        return;
      }
    }
    cudaFreeHost(block);
  }

  bool do_is_equal(const std::pmr::memory_resource& other) const noexcept override { return this == &other; }

  std::mutex mutex_;
  std::array<std::vector<void*>, 64> free_;  // by the binary logarithm of their size
  size_t keptBytes_ = 0;
  const size_t mostKept_ = mostKeptBytes();
};

PinnedPool& pinnedPool() {
  static PinnedPool pool;
  return pool;
}

}  // namespace

std::pmr::memory_resource* pinnedMemory() { return &pinnedPool(); }

void giveBackPinnedMemory() { pinnedPool().giveBack(); }

}  // namespace warpscope::cuda
