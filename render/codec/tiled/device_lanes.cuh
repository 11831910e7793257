// A stream of words on a device: a warp's threads are its lanes. All of them must call. The same stream as ans_lanes.h.
#pragma once

#include <cstdint>

#include "render/codec/tiled/ans.h"
#include "render/codec/tiled/device_sheet.h"
#include "render/codec/tokens.h"
#include "render/cuda/warp_reduce.cuh"

namespace warpscope {

static_assert(kAnsLanes == 32, "a lane is a thread of a warp");

__device__ inline uint32_t lanesBelow() {
  uint32_t mask;
  asm("mov.u32 %0, %%lanemask_lt;" : "=r"(mask));
  return mask;
}

/// Goes from the last symbol to the first, and from the end of its room to the front.
class WarpWriter {
 public:
  __device__ explicit WarpWriter(uint16_t* end) : end_(end) {}

  __device__ void put(const AnsWriterShare& own, bool isActive) {
    const bool gives = isActive && own.gives(state_);
    give(gives, static_cast<uint16_t>(state_));
    const uint32_t state = own.put(gives ? state_ >> 16 : state_);
    if (isActive) state_ = state;
  }
  /// The lower `count` bits, at most kAnsRestBits; none where there are none.
  __device__ void putBits(uint32_t bits, uint32_t count) {
    uint16_t word = 0;
    give(count > 0 && ansGivesForBits(state_, count, word), word);
    if (count > 0) state_ = ansPutBits(state_, bits & ((1u << count) - 1), count);
  }
  __device__ uint32_t state() const { return state_; }
  /// Words that were given away.
  __device__ uint32_t count() const { return count_; }

 private:
  __device__ void give(bool gives, uint16_t word) {
    const uint32_t giving = __ballot_sync(kAllLanes, gives);
    count_ += __popc(giving);
    if (gives) end_[static_cast<int>(__popc(giving & lanesBelow())) - static_cast<int>(count_)] = word;
  }

  uint32_t state_ = kAnsLow, count_ = 0;
  uint16_t* end_;
};

/// Calls put(prepare(symbol), whether the lane has one) for each step's symbols, the last first. Loads and what prepare() does go ahead of the calls, which wait for one another;
/// all lanes call it.
template <class T, class Prepare, class Put>
__device__ void fromTheEnd(const T* symbols, uint32_t size, const Prepare& prepare, const Put& put) {
  constexpr uint32_t kAhead = 8;  // steps
  using Ready = decltype(prepare(T{}));
  const uint32_t lane = threadIdx.x % 32;
  uint32_t steps = (size + 31) / 32;
  if (steps == 0) return;
  // Some first, of which the last may be of fewer than all lanes; then as many as go at once.
  const uint32_t some = (steps - 1) % kAhead + 1;
  T loaded[kAhead], next[kAhead];
  Ready ready[kAhead];
  const auto lookAtNext = [&](uint32_t left) {
    if (left == 0) return;
    const T* const last = symbols + (left - 1) * 32 + lane;
#pragma unroll
    for (uint32_t k = 0; k < kAhead; ++k) next[k] = *(last - k * 32);
  };
#pragma unroll
  for (uint32_t k = 0; k < kAhead; ++k) {
    const uint32_t i = (steps - 1 - k) * 32 + lane;
    loaded[k] = k < some && i < size ? symbols[i] : T{0};
  }
  lookAtNext(steps - some);
#pragma unroll
  for (uint32_t k = 0; k < kAhead; ++k) ready[k] = prepare(loaded[k]);
#pragma unroll
  for (uint32_t k = 0; k < kAhead; ++k)
    if (k < some) put(ready[k], (steps - 1 - k) * 32 + lane < size);
  for (steps -= some; steps > 0; steps -= kAhead) {
#pragma unroll
    for (uint32_t k = 0; k < kAhead; ++k) ready[k] = prepare(next[k]);
    lookAtNext(steps - kAhead);
#pragma unroll
    for (uint32_t k = 0; k < kAhead; ++k) put(ready[k], true);
  }
}

/// Past the end there are zeros, and isSound() is false.
class WarpReader {
 public:
  /// From its beginning, of `bytes` bytes: an even number, none if it has no words.
  __device__ WarpReader(const uint16_t* stream, uint32_t bytes) : words_(stream + 2 * kAnsLanes), hasStream_(bytes > 0) {
    if (bytes < kAnsStateBytes) {
      isBad_ = hasStream_;
      return;
    }
    const uint32_t lane = threadIdx.x % 32;
    at_.state = stream[2 * lane] | static_cast<uint32_t>(stream[2 * lane + 1]) << 16;
    isBad_ = ansWants(at_.state);
    count_ = (bytes - kAnsStateBytes) / 2;
    look();
  }

  /// Fills `symbols` of a model whose slots are `slots`.
  template <class T>
  __device__ void take(const uint32_t* slots, T* symbols, uint32_t size) {
    T* const own = symbols + threadIdx.x % 32;
    uint32_t begin = 0;
    for (; begin + 32 <= size; begin += 32) own[begin] = takeStep<T>(slots, true);
    if (begin == size) return;
    const bool isActive = begin + threadIdx.x % 32 < size;
    const T last = takeStep<T>(slots, isActive);
    if (isActive) own[begin] = last;
  }
  /// Fills `numbers` of a model that has one token alone.
  __device__ void takeRests(uint32_t token, uint32_t* numbers, uint32_t size) {
    const uint32_t lane = threadIdx.x % 32;
    for (uint32_t begin = 0; begin < size; begin += 32) {
      const bool isActive = begin + lane < size;
      const uint32_t value = takeRest(isActive ? token : 0);
      if (isActive) numbers[begin + lane] = value;
    }
  }

  __device__ bool hasStream() const { return hasStream_; }
  __device__ void blame() { isBad_ = true; }
  __device__ bool isBad() const { return isBad_; }
  __device__ bool isSound() const {
    return __all_sync(kAllLanes, !isBad_ && at_.next == count_ && (!hasStream_ || at_.state == kAnsLow));  // who took words that were not there is past the end
  }
  __device__ LaneState state() const { return at_; }
  /// Goes on where an earlier reader of the stream was.
  __device__ void goOnAt(const LaneState& at) {
    at_ = at;
    look();
  }

 private:
  __device__ uint32_t wordAt(uint32_t place) const { return place < count_ ? __ldg(words_ + place) : 0u; }
  /// The words that come next: the window's two halves, a word a lane each, and what comes behind it, which nobody waits for yet.
  __device__ void look() {
    window_ = at_.next;
    near_ = wordAt(window_ + threadIdx.x % 32);
    far_ = wordAt(window_ + 32 + threadIdx.x % 32);
    behind_ = wordAt(window_ + 64 + threadIdx.x % 32);
  }
  __device__ void refill(bool isActive) {
    const bool wants = isActive && ansWants(at_.state);
    const uint32_t wanting = __ballot_sync(kAllLanes, wants);
    const uint32_t inWindow = at_.next - window_ + __popc(wanting & lanesBelow());
    const uint32_t fromNear = __shfl_sync(kAllLanes, near_, inWindow), fromFar = __shfl_sync(kAllLanes, far_, inWindow);
    if (wants) at_.state = at_.state << 16 | (inWindow < 32 ? fromNear : fromFar);
    at_.next += __popc(wanting);
    if (at_.next - window_ < 32) return;
    window_ += 32;
    near_ = far_;
    far_ = behind_;
    behind_ = wordAt(window_ + 64 + threadIdx.x % 32);
  }
  template <class T>
  __device__ T takeStep(const uint32_t* slots, bool isActive) {
    const uint32_t slot = slots[at_.state & (kAnsScale - 1)];
    if (isActive) at_.state = ansTake(at_.state, slot);
    refill(isActive);
    const uint32_t symbol = isActive ? ansSymbolOf(slot) : 0;
    if constexpr (sizeof(T) > 1)
      return takeRest(symbol);
    else
      return static_cast<T>(symbol);
  }
  /// A token's number.
  __device__ uint32_t takeRest(uint32_t token) {
    const uint32_t bits = restBits(token);
    if (!__any_sync(kAllLanes, bits > 0)) return token;
    const uint32_t first = min(bits, kAnsRestBits), second = bits - first;
    uint32_t rest = at_.state & ((1u << first) - 1);
    at_.state >>= first;
    refill(first > 0);
    if (__any_sync(kAllLanes, second > 0)) {
      rest |= (at_.state & ((1u << second) - 1)) << kAnsRestBits;
      at_.state >>= second;
      refill(second > 0);
    }
    return valueOf(token, rest);
  }

  const uint16_t* words_;
  uint32_t count_ = 0;
  LaneState at_;
  uint32_t window_ = 0, near_ = 0, far_ = 0, behind_ = 0;
  bool hasStream_, isBad_ = false;
};

}  // namespace warpscope
