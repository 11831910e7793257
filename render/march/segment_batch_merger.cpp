// Looks at all segments of all rays, and what is done with the two that cost least.
// See segment_batch_merger.h.
#include "render/march/segment_batch_merger.h"

#include <algorithm>
#include <bit>
#include <limits>
#include <type_traits>

#include "render/core/simd_lanes.h"

namespace warpscope {
namespace {

constexpr float kNever = std::numeric_limits<float>::infinity();
/// Behind all places.
constexpr float kNowhere = 1000.0f;

/// What two neighbours become.
[[gnu::always_inline]] inline BasicRayExtent<FloatBatch> extentOf(const SegmentLanes& front, const SegmentLanes& back) {
  const FloatBatch depthA = depthBeside<FloatBatch>(front, back), depthB = depthBeside<FloatBatch>(back, front), depth = depthA + depthB;
  const auto hasDepth = depth > FloatBatch(0.0f);
  const auto extent = extentBySpread(front, back, depthB / xsimd::select(hasDepth, depth, FloatBatch(1.0f)));
  return {xsimd::select(hasDepth, extent.begin, front.begin), xsimd::select(hasDepth, extent.end, back.end)};
}
[[gnu::always_inline]] inline SegmentLanes mergedTo(const BasicRayExtent<FloatBatch>& extent, const SegmentLanes& front, const SegmentLanes& back) {
  const FloatBatch rest = 1.0f - front.opacity;
  SegmentLanes both{extent.begin, extent.end, mulAdd(rest, back.opacity, front.opacity), front.through, {}};
  for (int channel = 0; channel < 3; ++channel) both.color[channel] = mulAdd(rest, back.color[channel], front.color[channel]);
  return both;
}

/// What that costs, squared.
[[gnu::always_inline]] inline FloatBatch costOf(const BasicRayExtent<FloatBatch>& both, const SegmentLanes& front, const SegmentLanes& back) {
  const FloatBatch zero(0.0f), one(1.0f);
  const auto hasLength = both.length() > zero;
  const FloatBatch light = front.contribution() + back.contribution(), length = xsimd::select(hasLength, both.length(), one);
  const auto costs = front.contribution() > zero && back.contribution() > zero && back.end - front.begin > zero && light * length > FloatBatch(kLeastCostly);
  const FloatBatch perBoth = one / xsimd::select(costs, light * length, one);
  const FloatBatch cost = xsimd::select(costs, squaredMergeCost(front, back, both, xsimd::select(hasLength, light * perBoth, zero), length * perBoth), zero);
  return xsimd::select(cost == cost, cost, FloatBatch(kNever));  // what is no number costs most, as its bits do in BasicSegmentMerger; light and lengths of a ray come to none
}
[[gnu::always_inline]] inline FloatBatch costOf(const SegmentLanes& front, const SegmentLanes& back) { return costOf(extentOf(front, back), front, back); }

}  // namespace

SegmentBatchMerger::SegmentBatchMerger(int room) : room_(room) {
  for (int lane = 0; lane < kRays; ++lane) rays_[lane].batch_ = this, rays_[lane].lane_ = lane;
}

SegmentBatchMerger::Ray& SegmentBatchMerger::begin(int lane) {
  Ray& ray = rays_[lane];
  ray.count_ = 0;
  ray.group_ = Ray::kNoGroup;
  ray.places_ = Ray::kInOrder;
  unseen_[lane] = 0.0f;
  return ray;
}

SegmentBatchMerger::Ray& SegmentBatchMerger::begin(int lane, const SegmentMerger& other) {
  Ray& ray = begin(lane);
  unseen_[lane] = other.unseen_;
  ray.group_ = other.group_;
  ray.grouped_ = other.grouped_;
  for (int i = other.first(); i != SegmentMerger::kNone; i = other.behind(i)) {
    const int bits = 4 * ray.count_;
    ray.places_ = (ray.places_ & ~(uint64_t{15} << bits)) | static_cast<uint64_t>(i) << bits;
    ray.add(other[i]);
  }
  return ray;
}

int SegmentBatchMerger::placeOf(int lane, int i) const {
  return hasCosts_ ? static_cast<int>(places_[i][lane]) : static_cast<int>(rays_[lane].places_ >> (4 * i) & 15);
}

void SegmentBatchMerger::give(int lane, SegmentMerger& other) const {
  other = SegmentMerger(room_);
  other.size_ = size(lane);
  other.unseen_ = unseen_[lane];
  other.group_ = rays_[lane].group_;
  other.grouped_ = rays_[lane].grouped_;
  if (other.size_ == 0) return;
  other.tailPlace_ = placeOf(lane, other.size_ - 1);
  other.tail_ = segment(lane, other.size_ - 1);
  for (int i = 0; i + 1 < other.size_; ++i) {
    const int place = placeOf(lane, i), behind = placeOf(lane, i + 1);
    other.memory_.setSegment(place, segment(lane, i));
    other.memory_.setCost(place, std::bit_cast<uint32_t>(squaredMergeCost(segment(lane, i), segment(lane, i + 1))));
    other.next_.set(place, behind);
    other.before_.set(behind, place);
  }
}

/// Lists of rays do not begin a power of two apart, which caches take for places that exclude each other.
void SegmentBatchMerger::grow() {
  const int grown = 2 * capacity_ + (capacity_ == 0 ? 63 : 1);
  std::vector<Entry> entries(static_cast<size_t>(grown) * kRays);
  for (int lane = 0; lane < kRays; ++lane) std::copy_n(entries_.begin() + lane * capacity_, capacity_, entries.begin() + lane * grown);
  entries_.swap(entries);
  capacity_ = grown;
}

void SegmentBatchMerger::shorten(int lane) {
  hasCosts_ = isFinished_ = false;
  sizes_[lane] = static_cast<float>(room_);
  for (int i = 0; i < room_; ++i) where_[i][lane] = lane * capacity_ + i;
  SegmentMerger merged(room_);
  give(lane, merged);
  for (int i = room_; i < rays_[lane].count_; ++i) merged.add(entries_[static_cast<size_t>(lane * capacity_ + i)].segment);
  begin(lane, merged);
}

SegmentLanes SegmentBatchMerger::at(const IntBatch& where) const {
  const float* const numbers = &entries_.front().segment.begin;
  const Quads first = gatheredQuads(numbers, where + where), second = gatheredQuads(numbers, where + where + 1);
  return {first.of[0], first.of[1], first.of[2], first.of[3], {second.of[0], second.of[1], second.of[2]}};
}

void SegmentBatchMerger::store(const SegmentLanes& segments, const IntBatch& where, const Is& which) {
  float* const numbers = &entries_.front().segment.begin;
  const uint32_t lanes = bitsOf(which);
  scatterQuads({{segments.begin, segments.end, segments.opacity, segments.through}}, numbers, where + where, lanes);
  scatterQuads({{segments.color[0], segments.color[1], segments.color[2], FloatBatch(0.0f)}}, numbers, where + where + 1, lanes);
}

template <class F>
void SegmentBatchMerger::visitRoom(const F& f) {
  room_ > 8 ? f(std::integral_constant<int, kMostMergerRoom>()) : f(std::integral_constant<int, 8>());
}

/// And where all are.
template <int kRoom>
void SegmentBatchMerger::findCosts() {
  SegmentLanes own = at(IntBatch::load_aligned(where_[0]));
  for (int i = 0; i < kRoom; ++i) {
    for (int lane = 0; lane < kRays; ++lane) places_[i][lane] = static_cast<float>(rays_[lane].places_ >> (4 * i) & 15);
    if (i + 1 == kRoom) break;
    const SegmentLanes next = at(IntBatch::load_aligned(where_[i + 1]));
    costOf(own, next).store_aligned(costs_[i]);
    own = next;
  }
  hasCosts_ = true;
}

template <int kRoom>
SegmentBatchMerger::Cheapest SegmentBatchMerger::cheapest() const {
  Cheapest found{FloatBatch(0.0f), FloatBatch(kNever)};
  FloatBatch place(kNowhere);
  const FloatBatch last = sizes() - 1.0f;
  for (int i = 0; i + 1 < kRoom; ++i) {
    const FloatBatch number(static_cast<float>(i)), cost = FloatBatch::load_aligned(costs_[i]), ownPlace = FloatBatch::load_aligned(places_[i]);
    const auto isCheaper = number < last && (cost < found.cost || (cost == found.cost && ownPlace < place));
    found.at = xsimd::select(isCheaper, number, found.at);
    found.cost = xsimd::select(isCheaper, cost, found.cost);
    place = xsimd::select(isCheaper, ownPlace, place);
  }
  return found;
}

/// In the lanes of `merges`: merges the segments number `number` and the one behind; what follows moves up, and the entry at `whereNext` behind it, to merge with which costs the last
/// one `costOfNext`.
template <int kRoom>
void SegmentBatchMerger::mergePairs(const Is& merges, const FloatBatch& number, const IntBatch& whereNext, const FloatBatch& costOfNext) {
  const FloatBatch pair = xsimd::select(merges, number, FloatBatch(kNowhere));
  const auto numbered = [](int i) { return FloatBatch(static_cast<float>(i)); };
  const auto chosen = [](const Is& which, const IntBatch& a, const IntBatch& b) { return xsimd::select(xsimd::bool_cast(which), a, b); };
  const auto whereIs = [&](int i) { return i < kRoom ? IntBatch::load_aligned(where_[i]) : whereNext; };
  IntBatch before = whereIs(0), front = before, back = before, behind = before;
  for (int i = 0; i + 1 < kRoom; ++i) {
    const Is isIt = pair == numbered(i);
    if (i > 0) before = chosen(isIt, whereIs(i - 1), before);
    front = chosen(isIt, whereIs(i), front);
    back = chosen(isIt, whereIs(i + 1), back);
    behind = chosen(isIt, whereIs(i + 2), behind);
  }
  const SegmentLanes first = at(front), second = at(back), both = mergedTo(extentOf(first, second), first, second);
  store(both, front, merges);
  const FloatBatch costBefore = costOf(at(before), both), cost = costOf(both, at(behind));
  FloatBatch freed(0.0f);
  for (int i = 0; i < kRoom; ++i) {
    const Is isIt = pair == numbered(i), isBehind = pair < numbered(i);
    chosen(isBehind, whereIs(i + 1), whereIs(i)).store_aligned(where_[i]);
    const FloatBatch ownPlace = FloatBatch::load_aligned(places_[i]);
    freed = xsimd::select(pair + 1.0f == numbered(i), ownPlace, freed);
    const FloatBatch nextPlace = i + 1 < kRoom ? FloatBatch::load_aligned(places_[i + 1]) : freed;
    xsimd::select(isBehind, nextPlace, ownPlace).store_aligned(places_[i]);
    if (i + 1 == kRoom) break;
    const FloatBatch ownCost = FloatBatch::load_aligned(costs_[i]), nextCost = i + 2 < kRoom ? FloatBatch::load_aligned(costs_[i + 1]) : costOfNext;
    xsimd::select(isIt, cost, xsimd::select(isBehind, nextCost, xsimd::select(pair == numbered(i + 1), costBefore, ownCost))).store_aligned(costs_[i]);
  }
}

/// As BasicSegmentMerger's of a full one, in the lanes of `isThere`. `tail`: the last ones, whose entries are of before they have grown.
template <int kRoom>
void SegmentBatchMerger::add(SegmentLanes& tail, const IntBatch& whereNext, const Is& isThere) {
  const SegmentLanes next = at(whereNext);
  FloatBatch unseen = FloatBatch::load_aligned(unseen_);
  const auto extent = extentOf(tail, next);
  Is isMerged = isThere && isSurelyAtMost(tail, next, unseen), looks(false);
  if (xsimd::any(isThere && !isMerged)) {
    const FloatBatch cost = costOf(extent, tail, next);
    isMerged = isMerged || (isThere && cost <= unseen);
    looks = isThere && !isMerged;
    if (xsimd::any(looks)) {
      costOf(at(IntBatch::load_aligned(where_[kRoom - 2])), tail).store_aligned(costs_[kRoom - 2]);
      const Cheapest found = cheapest<kRoom>();
      const Is isOfTail = looks && cost <= found.cost;
      xsimd::select(looks, xsimd::select(isOfTail, cost, found.cost) * kMergedUnseenSquared, unseen).store_aligned(unseen_);
      isMerged = isMerged || isOfTail;
      looks = looks && !isOfTail;
      if (xsimd::any(looks)) {
        store(tail, IntBatch::load_aligned(where_[kRoom - 1]), looks);
        mergePairs<kRoom>(looks, found.at, whereNext, cost);
      }
    }
  }
  tail = selected(isMerged, mergedTo(extent, tail, next), selected(looks, next, tail));
}

void SegmentBatchMerger::merge(int rays) {
  if (capacity_ == 0) grow();
  alignas(64) float counts[kRays];
  alignas(64) int32_t firsts[kRays];
  int most = 0;
  for (int lane = 0; lane < kRays; ++lane) {
    const int count = lane < rays ? rays_[lane].count_ : 0;
    most = std::max(most, count);
    counts[lane] = static_cast<float>(count);
    firsts[lane] = lane * capacity_;
    sizes_[lane] = static_cast<float>(std::min(count, room_));
  }
  const IntBatch first = IntBatch::load_aligned(firsts);
  for (int i = 0; i < room_; ++i) (first + i).store_aligned(where_[i]);
  hasCosts_ = isFinished_ = false;
  if (most <= room_) return;
  visitRoom([&]<int kRoom>(std::integral_constant<int, kRoom>) {
    findCosts<kRoom>();
    const FloatBatch count = FloatBatch::load_aligned(counts);
    SegmentLanes tail = at(first + (kRoom - 1));
    for (int i = kRoom; i < most; ++i) add<kRoom>(tail, first + i, FloatBatch(static_cast<float>(i)) < count);
    store(tail, IntBatch::load_aligned(where_[kRoom - 1]), count > FloatBatch(static_cast<float>(kRoom)));
  });
}

void SegmentBatchMerger::finish(int most, const RayLattice* const* lattices) {
  const auto hasMore = [&] { return sizes() > FloatBatch(static_cast<float>(most)); };
  const auto ownAt = [&](int i) { return at(IntBatch::load_aligned(where_[i])); };
  if (xsimd::any(hasMore()))
    visitRoom([&]<int kRoom>(std::integral_constant<int, kRoom>) {
      if (hasCosts_)
        costOf(ownAt(kRoom - 2), ownAt(kRoom - 1)).store_aligned(costs_[kRoom - 2]);
      else
        findCosts<kRoom>();
      for (Is merges = hasMore(); xsimd::any(merges); merges = hasMore()) {
        mergePairs<kRoom>(merges, cheapest<kRoom>().at, IntBatch(0), FloatBatch(kNever));
        xsimd::select(merges, sizes() - 1.0f, sizes()).store_aligned(sizes_);
      }
    });
  alignas(64) float of[4][kRays] = {};
  int largest = 0;
  for (int lane = 0; lane < kRays; ++lane) {
    largest = std::max(largest, size(lane));
    const auto borders = size(lane) > 0 ? LatticeBorders<float>::of(*lattices[lane]) : LatticeBorders<float>{0.0f, 1.0f, 1.0f, 1.0f};
    of[0][lane] = borders.t0, of[1][lane] = borders.dt, of[2][lane] = borders.count, of[3][lane] = borders.end;
  }
  const auto loaded = [&](int i) { return FloatBatch::load_aligned(of[i]); };
  const LatticeBorders<FloatBatch> borders{loaded(0), loaded(1), loaded(2), loaded(3)};
  const FloatBatch zero(0.0f);
  FloatBatch last(-kNever);
  SegmentLanes own = largest > 0 ? ownAt(0) : SegmentLanes{};
  for (int i = 0; i < largest; ++i) {
    const SegmentLanes next = i + 1 < largest ? ownAt(i + 1) : own;
    const Is hasLength = own.length() > zero, isBeforePoint = FloatBatch(static_cast<float>(i + 1)) < sizes() && !(next.length() > zero);
    SegmentLanes settled = own;
    settle<FloatBatch>(settled, borders, last, xsimd::select(isBeforePoint, next.begin, FloatBatch(kNever)));
    own.begin = xsimd::select(hasLength, settled.begin, own.begin);
    own.end = xsimd::select(hasLength, settled.end, own.end);
    finished_[i].set(own);
    last = own.end;
    own = next;
  }
  isFinished_ = true;
}

}  // namespace warpscope
