// How often a march does what costs, so that tests can prove that what a plan leaves out is not done. For host and device.
// Compiled in where WARPSCOPE_COUNTERS is 1 (CMake's option of that name); elsewhere WARPSCOPE_COUNT is no code at all.
#pragma once

#include "render/core/host_device.h"

#if WARPSCOPE_COUNTERS

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string_view>
#include <vector>

namespace warpscope {

enum class Counter {
  rays,           ///< that were looked into, whether they meet the volume or not
  clippedRays,    ///< that were cut by planes, or by none
  samples,        ///< that were looked at; batches of the CPU's count whole
  voxels,         ///< that were read, for values and for gradients
  leaps,          ///< over cells that show nothing
  finiteChecks,   ///< of a sample's eight voxels
  refinements,    ///< of a bin of the transfer table
  corrections,    ///< of a table's opacity to the step
  gradients,
  diffuse,        ///< of a sample and light, on the CPU of a batch and light
  highlights,     ///< likewise
  halfVectors,    ///< likewise
  earlyEnds,      ///< of rays
  secondPasses,   ///< of rays: marches on a device, folds over stored samples on the CPU
  dividedRays,    ///< that were marched again part by part
  secondaryRays,  ///< towards lights and through occluders
  movedRays,      ///< by jitter
  maxima,         ///< of rays
  surfaces,       ///< that rays met
  segments,       ///< steps that were classified by their ends
  spreads,        ///< of depth, one for each sample that is sent
  segmentedRays,  ///< whose samples were merged into segments
};
inline constexpr size_t kCounters = static_cast<size_t>(Counter::segmentedRays) + 1;
inline constexpr std::array<std::string_view, kCounters> kCounterNames{
    "rays",      "clippedRays", "samples",    "voxels",      "leaps",     "finiteChecks", "refinements", "corrections",
    "gradients", "diffuse",     "highlights", "halfVectors", "earlyEnds", "secondPasses", "dividedRays", "secondaryRays",
    "movedRays",   "maxima",      "surfaces",    "segments",     "spreads",
    "segmentedRays"};

/// What was counted.
struct Counts {
  std::array<uint64_t, kCounters> of{};
  uint64_t operator[](Counter counter) const { return of[static_cast<size_t>(counter)]; }
  bool operator==(const Counts&) const = default;
};

/// Each thread adds to numbers of its own; they outlive it. Sums are whole where those that count have been waited for.
class HostCounts {
 public:
  static HostCounts& instance() {
    static HostCounts counts;
    return counts;
  }
  void add(Counter counter, uint64_t times) {
    thread_local Block& own = newBlock();
    std::atomic<uint64_t>& value = own[static_cast<size_t>(counter)];
    value.store(value.load(std::memory_order_relaxed) + times, std::memory_order_relaxed);  // nobody else writes
  }
  /// Since the last time.
  Counts take() {
    const std::scoped_lock lock(mutex_);
    Counts taken;
    for (const std::unique_ptr<Block>& block : blocks_)
      for (size_t i = 0; i < kCounters; ++i) taken.of[i] += (*block)[i].exchange(0, std::memory_order_relaxed);
    return taken;
  }

 private:
  using Block = std::array<std::atomic<uint64_t>, kCounters>;

  Block& newBlock() {
    const std::scoped_lock lock(mutex_);
    return *blocks_.emplace_back(std::make_unique<Block>());
  }

  std::mutex mutex_;
  std::vector<std::unique_ptr<Block>> blocks_;
};

#if defined(__CUDACC__)
/// A copy for each .cu file, which hands it over after its launches (march_kernels.cuh).
static __device__ unsigned long long deviceCounts[kCounters];
#endif

WARPSCOPE_HD inline void count(Counter counter, uint64_t times) {
#if defined(__CUDA_ARCH__)
  atomicAdd(&deviceCounts[static_cast<size_t>(counter)], static_cast<unsigned long long>(times));
#else
  HostCounts::instance().add(counter, times);
#endif
}

}  // namespace warpscope

#define WARPSCOPE_COUNT(counter, times) ::warpscope::count(::warpscope::Counter::counter, static_cast<uint64_t>(times))

#else

#define WARPSCOPE_COUNT(counter, times) static_cast<void>(0)

#endif
