// Merging a ray's samples into segments on the CPU: what all pairs of neighbours would cost at once, as lanes of vectors.
// What becomes of a ray is what BasicSegmentMerger (ray_segments.h) makes of it, bit for bit, by its formulas: that one keeps what each pair costs and computes it anew for
// the two beside a merge, one after the other; here that of all pairs is computed whenever it is asked for, which takes less time than two of them do.
#pragma once

#include <cstdint>

#include "render/core/simd.h"
#include "render/march/ray_segments.h"

namespace warpscope {

/// Segments of the ray that is marched, near to far.
class SegmentBatchMerger {
 public:
  static constexpr int kNone = -1;

  /// As BasicSegmentMerger's.
  explicit SegmentBatchMerger(int room) : room_(room) { clear(); }
  void clear() {
    size_ = 0;
    group_ = kNone;
    unseen_ = 0.0f;
    places_ = kInOrder;
  }

  /// Becomes what `other`, which has as much room, is; and the other way round.
  void take(const SegmentMerger& other);
  void give(SegmentMerger& other) const;

  /// Without the group that has not ended, here and below.
  int size() const { return size_; }
  int first() const { return behind(-1); }
  int behind(int i) const { return i + 1 < size_ ? i + 1 : kNone; }
  RaySegment operator[](int i) const { return i + 1 == size_ ? tail_ : at(i); }
  /// Where BasicSegmentMerger would have it.
  int placeOf(int i) const { return static_cast<int>(places_ >> (4 * i) & 15); }

  /// The sample of a step, which comes next. Ends groups by itself.
  static constexpr bool kIsToldOfGroups = false;
  void addStep(const RaySegment& next, int step) {
    if (size_ < room_) endGroup();  // of a ray that was handed on so
    if (size_ < room_) return add(next);
    const int group = step / kGroupedSteps;
    if (group == group_) return mergeInto(grouped_, next);
    endGroup();
    group_ = group;
    grouped_ = next;
  }
  /// What comes next along the ray, of no group, where none waits for its end.
  void add(const RaySegment& next) {
    if (size_ < room_) {
      if (size_ > 0) put(size_ - 1, tail_);
      tail_ = next;
      ++size_;
      return;
    }
    if (!isSurelyAtMost(tail_, next, unseen_)) {
      const float cost = squaredMergeCost(tail_, next);
      if (!(cost <= unseen_) && lookAtAll(next, cost)) return;
    }
    mergeInto(tail_, next);
  }

  void reduceTo(int most);
  void finish(int most, const RayLattice& lattice);

 private:
  static constexpr uint64_t kInOrder = 0xfedcba9876543210u;
  /// Vectors that hold a row of as many as there may be.
  static constexpr int kBatches = kMostMergerRoom > kBatchLanes ? kMostMergerRoom / kBatchLanes : 1, kRowLanes = kBatches * kBatchLanes;
  static constexpr int kRows = 7;  // begin, end, opacity, through, colour

  RaySegment at(int i) const {
    return {rows_[0][i], rows_[1][i], rows_[2][i], rows_[3][i], {rows_[4][i], rows_[5][i], rows_[6][i]}};
  }
  void put(int i, const RaySegment& segment) {
    const float of[kRows] = {segment.begin, segment.end, segment.opacity, segment.through, segment.color.x, segment.color.y, segment.color.z};
    for (int row = 0; row < kRows; ++row) rows_[row][i] = of[row];
  }

  /// Merges those two of all, the tail among them, that cost least and makes `next` the tail; false if none cost less than `cost`, that of the tail and `next`.
  bool lookAtAll(const RaySegment& next, float cost);
  template <int kCount>
  bool lookAtAllIn(const RaySegment& next, float cost);
  template <int kCount>
  void reduceIn(int most);
  void endGroup() {
    if (group_ != kNone) add(grouped_);
    group_ = kNone;
  }
  /// The one behind that at `first` is gone.
  void freePlaceBehind(int first);

  alignas(64) float rows_[kRows][kRowLanes] = {};
  int room_, size_ = 0;
  RaySegment tail_;        // the last one; its place in rows_ has anything
  int group_ = kNone;      // whose samples are kept, as one
  RaySegment grouped_;
  float unseen_ = 0.0f;    // what costs no more, squared, is merged into the tail without a look at the others
  uint64_t places_ = kInOrder;  // four bits each, of all that there is room for: those of segments, then those that are free
};

}  // namespace warpscope
