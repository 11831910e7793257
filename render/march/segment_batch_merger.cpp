// Looks at all pairs, and what is done with the cheapest.
// See segment_batch_merger.h.
#include "render/march/segment_batch_merger.h"

#include <bit>
#include <limits>
#include <type_traits>
#include <utility>

#include "render/core/simd_lanes.h"

namespace warpscope {
namespace {

constexpr float kNever = std::numeric_limits<float>::infinity();

/// A segment a lane. As RaySegment.
struct SegmentLanes {
  FloatBatch begin, end, opacity, through, color[3];

  FloatBatch contribution() const { return through * opacity; }
  FloatBatch length() const { return end - begin; }
};

/// What pairs of neighbours become, and what that costs.
struct PairLanes {
  SegmentLanes both;
  FloatBatch cost;
};
[[gnu::always_inline]] inline PairLanes pairsOf(const SegmentLanes& front, const SegmentLanes& back) {
  const FloatBatch zero(0.0f), one(1.0f);
  PairLanes pairs;
  const FloatBatch depthA = depthBeside<FloatBatch>(front, back), depthB = depthBeside<FloatBatch>(back, front), depth = depthA + depthB;
  const auto hasDepth = depth > zero;
  const auto extent = extentBySpread(front, back, depthB / xsimd::select(hasDepth, depth, one));
  const BasicRayExtent<FloatBatch> both{xsimd::select(hasDepth, extent.begin, front.begin), xsimd::select(hasDepth, extent.end, back.end)};
  const auto hasLength = both.length() > zero;
  const FloatBatch light = front.contribution() + back.contribution(), length = xsimd::select(hasLength, both.length(), one);
  const auto costs = front.contribution() > zero && back.contribution() > zero && back.end - front.begin > zero && light * length > FloatBatch(kLeastCostly);
  const FloatBatch perBoth = one / xsimd::select(costs, light * length, one);
  const FloatBatch cost = xsimd::select(costs, squaredMergeCost(front, back, both, xsimd::select(hasLength, light * perBoth, zero), length * perBoth), zero);
  pairs.cost = xsimd::select(cost == cost, cost, FloatBatch(kNever));  // what is no number costs most, as its bits do in BasicSegmentMerger
  pairs.both.begin = both.begin;
  pairs.both.end = both.end;
  const FloatBatch rest = 1.0f - front.opacity;
  pairs.both.opacity = mulAdd(rest, back.opacity, front.opacity);
  pairs.both.through = front.through;
  for (int channel = 0; channel < 3; ++channel) pairs.both.color[channel] = mulAdd(rest, back.color[channel], front.color[channel]);
  return pairs;
}

/// Each lane's next one's; the last one's is the first of `following`.
FloatBatch moved(const FloatBatch& lanes, const FloatBatch& following) {
#if XSIMD_WITH_AVX512F
  return _mm512_castsi512_ps(_mm512_alignr_epi32(_mm512_castps_si512(following), _mm512_castps_si512(lanes), 1));
#elif XSIMD_WITH_AVX2
  const __m256i own = _mm256_castps_si256(lanes), middle = _mm256_permute2x128_si256(own, _mm256_castps_si256(following), 0x21);
  return _mm256_castsi256_ps(_mm256_alignr_epi8(middle, own, sizeof(float)));
#else
  alignas(64) float both[2 * kBatchLanes];
  lanes.store_aligned(both);
  following.store_aligned(both + kBatchLanes);
  return FloatBatch::load_unaligned(both + 1);
#endif
}

float leastOf(const FloatBatch& numbers) {
#if XSIMD_WITH_AVX512F
  return _mm512_reduce_min_ps(numbers);
#elif XSIMD_WITH_AVX
  __m256 least = _mm256_min_ps(numbers, _mm256_permute2f128_ps(numbers, numbers, 1));
  least = _mm256_min_ps(least, _mm256_permute_ps(least, 0x4e));
  return _mm256_cvtss_f32(_mm256_min_ps(least, _mm256_permute_ps(least, 0xb1)));
#else
  alignas(64) float of[kBatchLanes];
  numbers.store_aligned(of);
  float least = kNever;
  for (const float number : of) least = minOf(number, least);
  return least;
#endif
}

FloatBatch lanesFrom(int first) {
  alignas(64) static constexpr float kNumbers[kMostMergerRoom + kBatchLanes] = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};
  return FloatBatch::load_aligned(kNumbers + first);
}

/// Calls `f(number of a, the same number of b)` for all numbers that a segment has.
template <class A, class B, class F>
[[gnu::always_inline]] inline void forEachRow(A& a, const B& b, const F& f) {
  f(a.begin, b.begin);
  f(a.end, b.end);
  f(a.opacity, b.opacity);
  f(a.through, b.through);
  for (int channel = 0; channel < 3; ++channel) f(a.color[channel], b.color[channel]);
}

/// Segments of a ray in kCount vectors.
template <int kCount>
struct Lanes {
  SegmentLanes of[kCount];

  [[gnu::always_inline]] void set(int i, const RaySegment& segment) {
    for (int batch = 0; batch < kCount; ++batch) {
      const auto isIt = lanesFrom(batch * kBatchLanes) == FloatBatch(static_cast<float>(i));
      forEachRow(of[batch], segment, [&](FloatBatch& row, float number) { row = xsimd::select(isIt, FloatBatch(number), row); });
    }
  }
};

/// All pairs of neighbours.
template <int kCount>
struct AllPairs {
  SegmentLanes back[kCount];
  PairLanes of[kCount];

  /// `next` is behind the last of all lanes.
  [[gnu::always_inline]] AllPairs(const Lanes<kCount>& front, const RaySegment& next) {
    for (int batch = 0; batch < kCount; ++batch) {
      back[batch] = front.of[batch];
      if (batch + 1 < kCount)
        forEachRow(back[batch], front.of[batch + 1], [](FloatBatch& row, const FloatBatch& following) { row = moved(row, following); });
      else
        forEachRow(back[batch], next, [](FloatBatch& row, float following) { row = moved(row, FloatBatch(following)); });
      of[batch] = pairsOf(front.of[batch], back[batch]);
    }
  }

  /// Of the first `count`: the one that costs least, and what; of equal ones the one in the lowest place.
  std::pair<int, float> cheapest(int count, const SegmentBatchMerger& merger) const {
    FloatBatch least(kNever);
    for (int batch = 0; batch < kCount; ++batch) {
      const auto isOne = lanesFrom(batch * kBatchLanes) < FloatBatch(static_cast<float>(count));
      least = xsimd::min(least, xsimd::select(isOne, of[batch].cost, FloatBatch(kNever)));
    }
    const float cost = leastOf(least);
    uint32_t equal = 0;
    for (int batch = 0; batch < kCount; ++batch) equal |= bitsOf(of[batch].cost == FloatBatch(cost)) << (batch * kBatchLanes);
    equal &= (uint32_t{1} << count) - 1;
    int pair = std::countr_zero(equal);
    while ((equal &= equal - 1) != 0)
      if (const int other = std::countr_zero(equal); merger.placeOf(other) < merger.placeOf(pair)) pair = other;
    return {pair, cost};
  }

  /// What there is when that pair has been merged.
  void merge(int pair, Lanes<kCount>& lanes) const {
    const FloatBatch merged(static_cast<float>(pair));
    for (int batch = 0; batch < kCount; ++batch) {
      const FloatBatch own = lanesFrom(batch * kBatchLanes);
      const auto isInFront = own < merged, isMerged = own == merged;
      forEachRow(lanes.of[batch], back[batch], [&](FloatBatch& row, const FloatBatch& behind) { row = xsimd::select(isInFront, row, behind); });
      forEachRow(lanes.of[batch], of[batch].both, [&](FloatBatch& row, const FloatBatch& both) { row = xsimd::select(isMerged, both, row); });
    }
  }
};

template <int kCount>
Lanes<kCount> loaded(const float* rows, int stride) {
  Lanes<kCount> lanes;
  for (int batch = 0; batch < kCount; ++batch) {
    const float* at = rows + batch * kBatchLanes;
    forEachRow(lanes.of[batch], lanes.of[batch], [&](FloatBatch& row, const FloatBatch&) {
      row = FloatBatch::load_aligned(at);
      at += stride;
    });
  }
  return lanes;
}

template <int kCount>
void store(const Lanes<kCount>& lanes, float* rows, int stride) {
  for (int batch = 0; batch < kCount; ++batch) {
    float* at = rows + batch * kBatchLanes;
    forEachRow(lanes.of[batch], lanes.of[batch], [&](const FloatBatch& row, const FloatBatch&) {
      row.store_aligned(at);
      at += stride;
    });
  }
}

/// Calls `f` with as many vectors as hold a row of a merger of that room.
template <class F>
auto visitCount(int room, const F& f) {
  constexpr auto vectorsFor = [](int lanes) { return lanes > kBatchLanes ? lanes / kBatchLanes : 1; };
  return room > 8 ? f(std::integral_constant<int, vectorsFor(kMostMergerRoom)>()) : f(std::integral_constant<int, vectorsFor(8)>());
}

}  // namespace

void SegmentBatchMerger::take(const SegmentMerger& other) {
  clear();
  unseen_ = other.unseen_;
  group_ = other.group_;
  grouped_ = other.grouped_;
  for (int i = other.first(); i != SegmentMerger::kNone; i = other.behind(i)) {
    if (size_ > 0) put(size_ - 1, tail_);
    tail_ = other[i];
    places_ = (places_ & ~(uint64_t{15} << (4 * size_))) | static_cast<uint64_t>(i) << (4 * size_);
    ++size_;
  }
}

void SegmentBatchMerger::give(SegmentMerger& other) const {
  other = SegmentMerger(room_);
  other.size_ = size_;
  other.unseen_ = unseen_;
  other.group_ = group_;
  other.grouped_ = grouped_;
  if (size_ == 0) return;
  other.tail_ = tail_;
  other.tailPlace_ = placeOf(size_ - 1);
  for (int i = 0; i + 1 < size_; ++i) {
    const int place = placeOf(i), behind = placeOf(i + 1);
    other.memory_.setSegment(place, at(i));
    other.memory_.setCost(place, std::bit_cast<uint32_t>(squaredMergeCost(at(i), (*this)[i + 1])));
    other.next_.set(place, behind);
    other.before_.set(behind, place);
  }
}

void SegmentBatchMerger::freePlaceBehind(int first) {
  const int bits = 4 * (first + 1), last = 4 * (room_ - 1);
  const uint64_t inFront = (uint64_t{1} << bits) - 1, freed = places_ >> bits & 15;
  const uint64_t behind = (places_ >> 4) & ~inFront & ((uint64_t{1} << last) - 1);
  places_ = (places_ & inFront) | behind | freed << last;
}

template <int kCount>
bool SegmentBatchMerger::lookAtAllIn(const RaySegment& next, float cost) {
  Lanes<kCount> lanes = loaded<kCount>(rows_[0], kRowLanes);
  lanes.set(room_ - 1, tail_);
  if (room_ < kCount * kBatchLanes) lanes.set(room_, next);
  AllPairs<kCount> pairs(lanes, next);
  const auto [pair, least] = pairs.cheapest(room_ - 1, *this);
  const bool isOfTail = cost <= least;
  unseen_ = kMergedUnseenSquared * (isOfTail ? cost : least);
  if (isOfTail) return false;
  pairs.merge(pair, lanes);
  store(lanes, rows_[0], kRowLanes);
  freePlaceBehind(pair);
  tail_ = next;
  return true;
}

bool SegmentBatchMerger::lookAtAll(const RaySegment& next, float cost) {
  return visitCount(room_, [&]<int kCount>(std::integral_constant<int, kCount>) { return lookAtAllIn<kCount>(next, cost); });
}

template <int kCount>
void SegmentBatchMerger::reduceIn(int most) {
  Lanes<kCount> lanes = loaded<kCount>(rows_[0], kRowLanes);
  lanes.set(size_ - 1, tail_);
  for (; size_ > most; --size_) {
    AllPairs<kCount> pairs(lanes, RaySegment{});
    const int pair = pairs.cheapest(size_ - 1, *this).first;
    pairs.merge(pair, lanes);
    freePlaceBehind(pair);
  }
  store(lanes, rows_[0], kRowLanes);
  tail_ = at(size_ - 1);
}

void SegmentBatchMerger::reduceTo(int most) {
  endGroup();
  if (size_ > most) visitCount(room_, [&]<int kCount>(std::integral_constant<int, kCount>) { reduceIn<kCount>(most); });
}

void SegmentBatchMerger::finish(int most, const RayLattice& lattice) {
  reduceTo(most);
  float last = -std::numeric_limits<float>::infinity();
  for (int i = 0; i < size_; ++i) {
    RaySegment segment = (*this)[i];
    if (segment.length() > 0.0f) {
      const bool isBeforePoint = i + 1 < size_ && !((*this)[i + 1].length() > 0.0f);
      settle(segment, lattice, last, isBeforePoint ? (*this)[i + 1].begin : std::numeric_limits<float>::infinity());
      rows_[0][i] = segment.begin, rows_[1][i] = segment.end;
      if (i + 1 == size_) tail_ = segment;
    }
    last = segment.end;
  }
}

}  // namespace warpscope
