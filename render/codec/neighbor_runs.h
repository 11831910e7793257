// Neighbours of values in their order, as runs: nearly everywhere those of one value are those of the value before it, each one further on. What is predicted from
// such neighbours is read one behind the other, by many lanes at once.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>

#include "render/codec/band_layout.h"

namespace warpscope {

/// f(number of a value, its neighbours), one after the other.
template <class F>
void forEachNeighbors(std::span<const NeighborRun> runs, const F& f) {
  for (const NeighborRun& run : runs)
    for (uint32_t i = 0; i < run.size; ++i) f(run.begin + i, run.at(i));
}

/// The slots that a run's values are predicted from, where all of them are known: what an encoder reads.
template <class T>
struct RunSlots {
  RunSlots(const T* slots, const NeighborRun& run) : west(slots + run.first.west), north(slots + run.first.north), northWest(slots + run.first.northWest) {}

  const T* west;
  const T* north;
  const T* northWest;
};

/// Values that are made one after the other, each from its neighbours: what a decoder does. `make`(number, west, north, north-west) returns the value, which is that of the
/// slot behind (band_layout.h). What became of the one before is the western neighbour in a run: it need not come back from memory. `Value`: what is calculated with.
template <class T, class Value, class Make>
class Making {
 public:
  Making(T* slots, Make make) : slots_(slots), make_(std::move(make)) {}

  void begin(const NeighborRun& run) {
    last_ = Value(slots_[run.first.west]);
    north_ = slots_ + run.first.north;
    northWest_ = slots_ + run.first.northWest;
  }
  /// Value number `k`, which is number `i` of the run.
  void step(size_t k, size_t i) {
    last_ = make_(k, last_, Value(north_[i]), Value(northWest_[i]));
    slots_[k + 1] = static_cast<T>(last_);
  }

 private:
  T* slots_;
  Make make_;
  Value last_{};
  const T* north_ = nullptr;
  const T* northWest_ = nullptr;
};
template <class T, class Make>
auto making(T* slots, Make make) {
  return Making<T, T, Make>(slots, std::move(make));
}

/// Each waits for what it made before, and none for another: together they take hardly longer than the slowest.
template <class... Makings>
void makeFromNeighbors(std::span<const NeighborRun> runs, Makings... makings) {
  for (const NeighborRun& run : runs) {
    (makings.begin(run), ...);
    for (size_t i = 0; i < run.size; ++i) (makings.step(run.begin + i, i), ...);
  }
}

/// So many rows without gaps are made at once (neighbor_rows.h).
inline constexpr uint32_t kRowsAtOnce = 4;

/// Rows one below the other, and another one like them above the first; what is west of a row's first value is what is above it.
struct NeighborRows {
  uint32_t begin = 0, width = 0, count = 0;  ///< number of the first value; values of a row, a multiple of kRowsAtOnce; rows, such a multiple too
};

}  // namespace warpscope
