// Merging the samples of as many rays as vectors have lanes on the CPU, side by side.
// Rays are marched one after the other, and of each is kept what it meets: samples while there is room for them as they are, from then on groups (ray_segments.h). When as many
// rays have been marched as there are lanes these are merged, of all rays at once, what they have met first before what they have met second: to what BasicSegmentMerger makes
// of each, bit for bit, by its formulas. A look at all segments of a ray takes as long for one ray as for all, and in most turns some ray wants one.
// A ray's segments stay where they are while their order changes: vectors get them four numbers at a time.
#pragma once

#include <cstdint>
#include <vector>

#include "render/march/ray_segments.h"
#include "render/march/segment_lanes.h"

namespace warpscope {

class SegmentBatchMerger {
 public:
  static constexpr int kRays = kBatchLanes;

  /// One of the rays, while it is marched.
  class Ray {
   public:
    Ray(const Ray&) = delete;
    Ray& operator=(const Ray&) = delete;

    /// As BasicSegmentMerger's. Ends groups by itself.
    static constexpr bool kIsToldOfGroups = false;
    void addStep(const RaySegment& next, int step) {
      if (count_ < batch_->room_) endGroup();  // of a ray that was handed on so
      if (count_ < batch_->room_) return add(next);
      const int group = step / kGroupedSteps;
      if (group == group_) return mergeInto(grouped_, next);
      endGroup();
      group_ = group;
      grouped_ = next;
    }
    void add(const RaySegment& next) {
      if (count_ == kMostEntries) batch_->shorten(lane_);
      batch_->put(lane_, count_++, next);
    }

    /// Nothing else of the group follows.
    void endGroup() {
      if (group_ != kNoGroup) add(grouped_);
      group_ = kNoGroup;
    }

   private:
    friend class SegmentBatchMerger;
    static constexpr int kNoGroup = -1;
    static constexpr uint64_t kInOrder = 0xfedcba9876543210u;

    Ray() = default;

    SegmentBatchMerger* batch_ = nullptr;
    int lane_ = 0, count_ = 0;
    int group_ = kNoGroup;        // that has not ended
    RaySegment grouped_;          // its samples, as one
    uint64_t places_ = kInOrder;  // four bits each: where BasicSegmentMerger would have what was handed on
  };

  /// `room`: segments that are kept of a ray until it has ended; 8 or 16.
  explicit SegmentBatchMerger(int room);
  SegmentBatchMerger(const SegmentBatchMerger&) = delete;
  SegmentBatchMerger& operator=(const SegmentBatchMerger&) = delete;

  /// The ray in that lane is one that has met nothing, or what was handed on, which has as much room. Lanes are taken from 0 on.
  Ray& begin(int lane);
  Ray& begin(int lane, const SegmentMerger& other);

  /// Merges what the rays in the first so many lanes have met, but for groups that have not ended. Once, before each is begun anew; what follows is of these.
  void merge(int rays);
  /// `other` becomes what the ray is.
  void give(int lane, SegmentMerger& other) const;
  /// Of rays that have ended, as BasicSegmentMerger's finish(), once. `lattices`: of each ray that has segments.
  void finish(int most, const RayLattice* const* lattices);

  int size(int lane) const { return static_cast<int>(sizes_[lane]); }
  FloatBatch sizes() const { return FloatBatch::load_aligned(sizes_); }
  /// The i-th, near to far.
  RaySegment segment(int lane, int i) const { return isFinished_ ? finished_[i].segment(lane) : entries_[static_cast<size_t>(where_[i][lane])].segment; }
  /// All rays' i-th, when they are finished.
  SegmentLanes lanes(int i) const { return finished_[i].lanes(); }
  /// Where BasicSegmentMerger would have it.
  int placeOf(int lane, int i) const;

 private:
  using Is = xsimd::batch_bool<float>;
  /// Of a ray until it is merged, at most.
  static constexpr int kMostEntries = 1023;
  struct alignas(8 * sizeof(float)) Entry {  // two fours of numbers
    RaySegment segment;
  };

  void put(int lane, int i, const RaySegment& segment) {
    if (i >= capacity_) grow();
    entries_[static_cast<size_t>(lane * capacity_ + i)].segment = segment;
  }
  void grow();
  /// Merges what the ray has met by itself: one that is so long must not take memory for all.
  void shorten(int lane);
  /// All rays' entries at these places.
  SegmentLanes at(const IntBatch& where) const;
  void store(const SegmentLanes& segments, const IntBatch& where, const Is& which);
  /// Calls `f` with the room, known when it is compiled: std::integral_constant.
  template <class F>
  void visitRoom(const F& f);
  template <int kRoom>
  void findCosts();
  template <int kRoom>
  void add(SegmentLanes& tail, const IntBatch& whereNext, const Is& isThere);
  template <int kRoom>
  void mergePairs(const Is& merges, const FloatBatch& at, const IntBatch& whereNext, const FloatBatch& costOfNext);
  struct Cheapest {
    FloatBatch at, cost;
  };
  template <int kRoom>
  Cheapest cheapest() const;

  int room_;
  bool hasCosts_ = false;       // and places
  bool isFinished_ = false;     // segments are in `finished_`
  Ray rays_[kRays];
  int capacity_ = 0;            // places for entries of each ray
  std::vector<Entry> entries_;  // what the rays have met, near to far, and what that has become
  alignas(64) float sizes_[kRays] = {};
  alignas(64) int32_t where_[kMostMergerRoom][kRays] = {};  // which entries the segments are, near to far
  alignas(64) float unseen_[kRays] = {};                    // what costs no more, squared, is merged into the last one without a look at the others
  alignas(64) float costs_[kMostMergerRoom][kRays] = {};    // of merging each with the one behind it, squared; that of the last two may be of before one has grown
  alignas(64) float places_[kMostMergerRoom][kRays] = {};
  SegmentRow finished_[kMostMergerRoom] = {};
};

}  // namespace warpscope
