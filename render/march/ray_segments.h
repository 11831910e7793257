// A ray's samples merged into segments: stretches of it that are taken as homogeneous, near to far, not overlapping. For host and device.
// Volumetric depth images: Frey, Sadlo, Ertl 2013; merging neighbours bottom-up: Keogh et al. 2001 ("segmenting time series"). What a merge costs is ours.
//
// A segment has the light and the opacity of all the samples that became it, as seen from the ray's beginning with nothing in front: segments over one another
// are the ray (Porter, Duff 1984), however they were merged. What is lost is where within the segment they were. So two become the homogeneous stretch whose optical depth
// has the same mean place and the same mean distance between any two of its places (Gini 1912; a standard deviation would take a root, and pictures are no better by it), cut off where that would
// reach beyond both: a surface with haze before it stays as thin as a surface, and what is homogeneous stays what it is (a twenty-fifth shorter where it is nearly opaque). Optical depth is
// taken as a / (1 - a / 2), a being the opacity: right up to a^3 / 12, and without a logarithm.
//
// The cost of merging two neighbours is how far light is moved along the ray, which from an angle is beside it, and how much of it changes colour:
//   moved: the light of both times sqrt(their length times the integral along the ray of the squared difference between where it comes from and the stretch that they become): the
//     distance of Cramer 1928 and von Mises, no less than the earth mover's (Rubner, Tomasi, Guibas 1998), by the inequality of Cauchy and Schwarz, and without cases; about, with
//     two places looked at (of random pairs nine in ten are within 0.3 and 1.4 of it, and pictures the same). Weights are light, not depth: what the frame hardly sees may be merged sooner.
//   recoloured: a b / (a + b) times the difference of the straight colours (the largest of three channels) times half of the length of both, a and b
//     being what both contribute to the picture: transmittance in front times opacity.
// Both are light times length. The cost is the root of the sum of their squares, and is compared squared. What other ways of merging are worth: tests/bench.
#pragma once

#include <cstdint>
#include <cstring>

#include "render/march/frame_segments.h"
#include "render/march/march.h"

namespace warpscope {

/// A stretch of a ray. Distances along the ray from its beginning, volume units.
struct RaySegment {
  float begin = 0.0f, end = 0.0f;
  float opacity = 0.0f;   ///< of it alone
  float through = 1.0f;   ///< transmittance of what lies in front
  glm::vec3 color{0.0f};  ///< linear, premultiplied, as if nothing lay in front

  WARPSCOPE_HD float contribution() const { return through * opacity; }
  WARPSCOPE_HD float length() const { return end - begin; }
};

/// Where on the ray a segment's light is taken to be.
WARPSCOPE_HD inline float placeToLight(const RaySegment& segment) { return mulAdd(placeOfHalf(segment.opacity), segment.length(), segment.begin); }

/// A stretch of a ray. `Number`: float, or a vector of as many rays or pairs as it has lanes, here and below.
template <class Number>
struct BasicRayExtent {
  Number begin, end;

  WARPSCOPE_HD Number length() const { return end - begin; }
};
using RayExtent = BasicRayExtent<float>;

/// Where what two neighbours become begins and ends, if they have any depth. `ofBack`: the back's share of it.
template <class Number, class Segment>
WARPSCOPE_HD inline BasicRayExtent<Number> extentBySpread(const Segment& front, const Segment& back, const Number& ofBack) {
  const Number ofFront = 1.0f - ofBack;
  // From the front's beginning on: both halves, from middle to middle, the mean. Two places of what is homogeneous are a third of its length apart in the mean.
  const Number halfA = 0.5f * front.length(), halfB = 0.5f * back.length(), apart = (back.begin - front.begin) + halfB - halfA, mean = mulAdd(ofBack, apart, halfA);
  const Number half = mulAdd(3.0f * ofFront * ofBack, apart, mulAdd(ofFront * ofFront, halfA, ofBack * ofBack * halfB));
  return {front.begin + maxOf(mean - half, 0.0f), minOf(front.begin + (mean + half), back.end)};
}

/// Depths of two neighbours, each as it weighs in what they become, in a unit in which they need no division.
template <class Number, class Segment>
WARPSCOPE_HD inline Number depthBeside(const Segment& segment, const Segment& neighbour) {
  return segment.opacity * mulAdd(neighbour.opacity, -0.5f, 1.0f);
}

/// Where what two neighbours become begins and ends.
WARPSCOPE_HD inline RayExtent mergedExtent(const RaySegment& front, const RaySegment& back) {
  const float depthA = depthBeside<float>(front, back), depthB = depthBeside<float>(back, front), depth = depthA + depthB;
  if (!(depth > 0.0f)) return {front.begin, back.end};
  return extentBySpread(front, back, depthB / depth);
}

/// `front` becomes both. `back` follows it.
WARPSCOPE_HD inline void mergeInto(RaySegment& front, const RaySegment& back) {
  const RayExtent both = mergedExtent(front, back);
  const float rest = 1.0f - front.opacity;
  front.begin = both.begin;
  front.end = both.end;
  front.opacity = mulAdd(rest, back.opacity, front.opacity);
  for (int channel = 0; channel < 3; ++channel) front.color[channel] = mulAdd(rest, back.color[channel], front.color[channel]);
}

/// The integral along the ray of the squared difference between the shares of light that `both` have sent up to a place, homogeneous, and that the two have. `ofBack`: the back's share.
/// `perUnit`: 1 over the length of `both`, 0 where that has none. About: the difference is a line between the ends that face each other and from there to the ends of `both`, and nothing beyond.
template <class Number, class Segment>
WARPSCOPE_HD inline Number squaredDifference(const Segment& front, const Segment& back, const BasicRayExtent<Number>& both, const Number& perUnit, const Number& ofBack) {
  const Number ofFront = 1.0f - ofBack;
  const auto sentUpTo = [&](const Number& t) { return minOf(maxOf((t - both.begin) * perUnit, 0.0f), 1.0f); };
  const Number atFront = ofFront - sentUpTo(front.end), atBack = ofFront - sentUpTo(back.begin);
  const Number before = maxOf(front.end - both.begin, 0.0f), behind = maxOf(both.end - back.begin, 0.0f), between = back.begin - front.end;
  const Number atEnds = mulAdd(before + between, atFront * atFront, (behind + between) * atBack * atBack);
  return mulAdd(between, atFront * atBack, atEnds) * (1.0f / 3);
}

/// By how much the straight colours of two differ, times both of their opacities.
template <class Number, class Segment>
WARPSCOPE_HD inline Number colorDifference(const Segment& front, const Segment& back) {
  Number most(0.0f);
  for (int channel = 0; channel < 3; ++channel) most = maxOf(most, absOf(front.color[channel] * back.opacity - back.color[channel] * front.opacity));
  return most;
}

/// Light times length by which merging two neighbours changes their colour, times the light of both.
template <class Number, class Segment>
WARPSCOPE_HD inline Number recolored(const Segment& front, const Segment& back) {
  return front.through * back.through * colorDifference<Number>(front, back) * (0.5f * (back.end - front.begin));
}

/// Whether merging the two costs, squared, no more than `squared`, without a division: as if they became all from the first one's beginning to the second one's end. Hardly ever says so
/// where squaredMergeCost() is more; always of light below some 1e-11, which nobody sees and whose fourth power is no number.
template <class Number, class Segment>
WARPSCOPE_HD inline auto isSurelyAtMost(const Segment& front, const Segment& back, const Number& squared) {
  const Number lightA = front.contribution(), lightB = back.contribution(), light = lightA + lightB, length = back.end - front.begin;
  // The difference is a line on each of the three parts: without a gap its square has a third of the largest.
  const Number ofLargest = selected(back.begin > front.end, Number(1.0f), Number(0.57735027f));
  const Number moved = maxOf(absOf(mulAdd(lightA, length, -(front.length() * light))), absOf(mulAdd(lightB, length, -(back.length() * light))));
  const Number lightMoved = ofLargest * moved * light, lightRecolored = recolored<Number>(front, back);
  return mulAdd(lightMoved, lightMoved, lightRecolored * lightRecolored) <= squared * (light * light);
}

/// Merging what has no more light times length (light alone, where what two become has no length) costs nothing: its square is less than a number holds. The inverse of more is finite.
inline constexpr float kLeastCostly = 1e-30f;

/// What merging two costs that have light and become `both`, squared. `perLight`: 1 over the light of both.
template <class Number, class Segment>
WARPSCOPE_HD inline Number squaredMergeCost(const Segment& front, const Segment& back, const BasicRayExtent<Number>& both, const Number& perUnit, const Number& perLight) {
  const Number light = front.contribution() + back.contribution(), length = back.end - front.begin;
  const Number squaredMove = maxOf(length * squaredDifference(front, back, both, perUnit, back.contribution() * perLight), 0.0f);
  const Number lightRecolored = recolored<Number>(front, back) * perLight;
  return mulAdd(light * light, squaredMove, lightRecolored * lightRecolored);
}

/// What merging the two would cost, squared; 0 or more.
WARPSCOPE_HD inline float squaredMergeCost(const RaySegment& front, const RaySegment& back) {
  if (!(front.contribution() > 0.0f) || !(back.contribution() > 0.0f) || !(back.end - front.begin > 0.0f)) return 0.0f;
  const RayExtent both = mergedExtent(front, back);
  const bool hasLength = both.length() > 0.0f;
  const float light = front.contribution() + back.contribution(), length = hasLength ? both.length() : 1.0f;
  if (!(light * length > kLeastCostly)) return 0.0f;
  const float perBoth = 1.0f / (light * length);  // one division for both
  return squaredMergeCost(front, back, both, hasLength ? light * perBoth : 0.0f, length * perBoth);
}

/// Where the steps of rays' lattices end, by whole numbers.
template <class Number>
struct LatticeBorders {
  Number t0, dt, count, end;

  WARPSCOPE_HD static LatticeBorders of(const RayLattice& lattice) {
    return {lattice.t0, lattice.dt, static_cast<float>(lattice.count), lattice.border(lattice.count)};
  }
  WARPSCOPE_HD Number borderAt(const Number& i) const { return selected(i < count, mulAdd(i, dt, t0), end); }
};

/// Moves the ends of a segment, or of each lane's one that has a length, to the nearest borders of steps, at least one step apart, between `from` and `to`.
template <class Number, class Segment, class Lattice>
WARPSCOPE_HD inline void settle(Segment& segment, const Lattice& lattice, const Number& from, const Number& to) {
  const Number perStep = 1.0f / lattice.dt;
  const auto stepsTo = [&](const Number& t) -> Number { return maxOf((t - lattice.t0) * perStep, 0.0f); };
  const auto whole = [](const Number& steps) -> Number { return converted(truncated(steps)); };
  Number begin = whole(stepsTo(segment.begin) + 0.5f), end = whole(stepsTo(segment.end) + 0.5f);
  const auto isApart = begin < end;
  begin = selected(isApart, begin, whole(stepsTo(mulAdd(Number(0.5f), segment.length(), segment.begin))));
  end = selected(isApart, end, begin + 1.0f);
  segment.begin = minOf(maxOf(lattice.borderAt(begin), from), to);
  segment.end = minOf(maxOf(lattice.borderAt(end), segment.begin), to);
}

/// A full merger merges with its last segment, without a look at the others, what costs no more than so many times what the last merge cost for which it looked. By 4 it looks half as often as by 1,
/// at 0.02 dB from any angle (0.3 of 80 in the frame's own view): tests/bench. Squared, as costs are.
inline constexpr float kMergedUnseenSquared = 4.0f * 4.0f;

/// Places of a merger at most.
inline constexpr int kMostMergerRoom = 16;

/// From every such step of a lattice on, the samples of so many become one before a full merger takes them: there are fewer to look for, and the rays of a warp, which meet what they do at
/// different steps, look in the same turns of the march. What that costs: tests/bench.
inline constexpr int kGroupedSteps = 8;

/// Segments that are kept of a ray until it has ended, where `most` are wanted of it. A device has the less room for rays the more each holds; twice as many as are
/// wanted measured as good as four times (PSNR within 0.1 dB from every angle), so that there are two sizes.
WARPSCOPE_HD constexpr int mergerRoomFor(int most) { return most <= 4 ? 8 : kMostMergerRoom; }

/// Where a merger keeps what it holds: by default in itself. Places for segments, and for what merging each with the one behind it costs, squared.
class OwnMergerMemory {
 public:
  /// How many it has room for, if that is known when it is compiled; 0: as the merger says.
  static constexpr int kRoom = 0;

  WARPSCOPE_HD RaySegment segment(int i) const { return segments_[i]; }
  WARPSCOPE_HD void setSegment(int i, const RaySegment& segment) { segments_[i] = segment; }
  WARPSCOPE_HD uint32_t cost(int i) const { return costs_[i]; }
  WARPSCOPE_HD void setCost(int i, uint32_t cost) { costs_[i] = cost; }

 private:
  RaySegment segments_[kMostMergerRoom];
  uint32_t costs_[kMostMergerRoom] = {};  // also where there is no room: mergers are compared and sent as bytes
};

/// The order of up to 16 places, four bits each: in a register, where an array that is indexed would be in memory.
class PlaceList {
 public:
  WARPSCOPE_HD int operator[](int i) const { return static_cast<int>(bits_ >> (4 * i) & 15); }
  WARPSCOPE_HD void set(int i, int place) { bits_ = (bits_ & ~(uint64_t{15} << (4 * i))) | static_cast<uint64_t>(place) << (4 * i); }

 private:
  uint64_t bits_ = 0;
};

class SegmentBatchMerger;  // segment_batch_merger.h

/// Segments of the ray that is marched, few at any time: when there is no room for another, the two are merged for which that costs least.
template <class Memory>
class BasicSegmentMerger {
 public:
  static_assert(kMostMergerRoom <= 16);  // PlaceList
  /// Behind the last one.
  static constexpr int kNone = -1;

  /// `room`: segments that are kept until the ray has ended; 8 or 16.
  WARPSCOPE_HD explicit BasicSegmentMerger(int room, const Memory& memory = {}) : memory_(memory), room_(room) { clear(); }
  WARPSCOPE_HD void clear() {
    size_ = 0;
    group_ = kNone;
    tailPlace_ = kNone;
    unseen_ = 0.0f;
    isTailRenewed_ = true;
    for (int i = 0; i < room(); ++i) memory_.setCost(i, kNever);
  }

  /// Becomes what `other` is, which has as much room and keeps what it holds elsewhere.
  template <class Other>
  WARPSCOPE_HD void take(const BasicSegmentMerger<Other>& other) {
    size_ = other.size_;
    tailPlace_ = other.tailPlace_;
    tail_ = other.tail_;
    grouped_ = other.grouped_;
    group_ = other.group_;
    unseen_ = other.unseen_;
    isTailRenewed_ = other.isTailRenewed_;
    next_ = other.next_;
    before_ = other.before_;
    for (int i = 0; i < room(); ++i) memory_.setCost(i, other.memory_.cost(i));
    for (int i = first(); i != kNone && i != tailPlace_; i = behind(i)) memory_.setSegment(i, other.memory_.segment(i));
  }

  /// Without the group that has not ended, here and below: after finish() there is none.
  WARPSCOPE_HD int size() const { return size_; }
  WARPSCOPE_HD bool isEmpty() const { return size_ == 0 && group_ == kNone; }
  /// The nearest, and the one behind one; kNone if there is none.
  WARPSCOPE_HD int first() const { return size_ > 0 ? 0 : kNone; }  // nothing is merged into what lies behind it
  WARPSCOPE_HD int behind(int i) const { return i == tailPlace_ ? kNone : next_[i]; }
  WARPSCOPE_HD RaySegment operator[](int i) const { return i == tailPlace_ ? tail_ : memory_.segment(i); }

  /// The sample of a step, which comes next: kept for endGroup(), which is called before the next group's is added, and as soon as wantsGroupToEnd().
  static constexpr bool kIsToldOfGroups = true;
  WARPSCOPE_HD void addStep(const RaySegment& next, int step) {
    if (group_ == kNone) {
      group_ = step / kGroupedSteps;
      grouped_ = next;
    } else {
      mergeInto(grouped_, next);
    }
  }
  WARPSCOPE_HD bool wantsGroupToEnd() const { return size_ < room() && group_ != kNone; }
  /// Adds the group in front of `step`, if there is one.
  WARPSCOPE_HD void endGroup(int step) {
    if (group_ == kNone || (size_ == room() && step / kGroupedSteps <= group_)) return;
    add(grouped_);
    group_ = kNone;
  }

  /// What comes next along the ray, of no group, where none waits for its end. Of the rays of a warp some merge with their last segment while others look at all: what each of them does stands in one place, where those that do it meet.
  WARPSCOPE_HD void add(const RaySegment& next) {
    const bool isFull = size_ == room();
    bool isMerged = isFull && isSurelyAtMost<float>(tail_, next, unseen_);
    int place = size_;
    if (size_ > 0 && !isMerged) {
      uint32_t cost = costOf(tail_, next);
      isMerged = isFull && costOfBits(cost) <= unseen_;
      if (isFull && !isMerged) {
        renewTail();
        const int cheapest = cheapestPair();
        const uint32_t least = memory_.cost(cheapest);
        isMerged = cost <= least;
        unseen_ = kMergedUnseenSquared * costOfBits(isMerged ? cost : least);
        if (!isMerged) {
          place = next_[cheapest];
          const bool isOfTail = place == tailPlace_;
          const uint32_t renewed = mergePair(cheapest, next);
          if (isOfTail) cost = renewed;
        }
      }
      if (!isMerged) {
        memory_.setSegment(tailPlace_, tail_);
        memory_.setCost(tailPlace_, cost);
        next_.set(tailPlace_, place);
        before_.set(place, tailPlace_);
      }
    }
    if (isMerged) {
      mergeInto(tail_, next);
      isTailRenewed_ = false;
      return;
    }
    memory_.setCost(place, kNever);
    tail_ = next;
    tailPlace_ = place;
    ++size_;
  }

  /// Merges until no more than `most`, at least 1, are left.
  WARPSCOPE_HD void reduceTo(int most) {
    endGroup(kBehindAll);
    if (size_ > most) renewTail();
    while (size_ > most) mergePair(cheapestPair(), tail_);
  }

  /// Of a ray that has ended: as reduceTo(), and what has a length begins and ends where steps of the ray's lattice do. Neighbouring rays' do there as well, so that
  /// coding them takes a quarter less.
  WARPSCOPE_HD void finish(int most, const RayLattice& lattice) {
    reduceTo(most);
    float last = -INFINITY;
    for (int i = first(); i != kNone; i = behind(i)) {
      RaySegment segment = (*this)[i];
      if (segment.length() > 0.0f) {
        const bool isBeforePoint = i != tailPlace_ && !((*this)[next_[i]].length() > 0.0f);
        settle<float>(segment, LatticeBorders<float>::of(lattice), last, isBeforePoint ? (*this)[next_[i]].begin : INFINITY);
        i == tailPlace_ ? void(tail_ = segment) : memory_.setSegment(i, segment);
      }
      last = segment.end;
    }
  }

 private:
  template <class>
  friend class BasicSegmentMerger;
  friend class SegmentBatchMerger;
  static constexpr uint32_t kNever = 0xffffffffu;
  static constexpr int kBehindAll = 0x7fffffff;

  WARPSCOPE_HD int room() const {
    if constexpr (Memory::kRoom > 0)
      return Memory::kRoom;
    else
      return room_;
  }
  /// Of numbers that are not negative, in their order.
  WARPSCOPE_HD static uint32_t bitsOfCost(float cost) {
    uint32_t bits;
    std::memcpy(&bits, &cost, sizeof bits);
    return bits;
  }
  WARPSCOPE_HD static float costOfBits(uint32_t bits) {
    float cost;
    std::memcpy(&cost, &bits, sizeof cost);
    return cost;
  }

  /// The first of the two that cost least; of equal ones the one in the lowest place.
  WARPSCOPE_HD int cheapestPair() const {
    uint32_t least = kNever;
    int cheapest = 0;
    for (int eight = 0; eight < room(); eight += 8)
      for (int i = eight; i < eight + 8; ++i) {
        const uint32_t cost = memory_.cost(i);
        cheapest = cost < least ? i : cheapest;
        least = cost < least ? cost : least;
      }
    return cheapest;
  }

  WARPSCOPE_HD static uint32_t costOf(const RaySegment& front, const RaySegment& back) { return bitsOfCost(squaredMergeCost(front, back)); }

  /// What merging the last two costs, if the last one has grown.
  WARPSCOPE_HD void renewTail() {
    if (!isTailRenewed_ && size_ > 1) memory_.setCost(before_[tailPlace_], costOf(memory_.segment(before_[tailPlace_]), tail_));
    isTailRenewed_ = true;
  }

  /// Merges the one at `first` and the one behind it, whose place becomes free. Returns what merging that with what follows would cost; `next` follows the last one.
  WARPSCOPE_HD uint32_t mergePair(int first, const RaySegment& next) {
    const int second = next_[first];
    const bool isLast = second == tailPlace_;
    RaySegment both = memory_.segment(first);
    mergeInto(both, (*this)[second]);
    const uint32_t cost = costOf(both, isLast ? next : (*this)[next_[second]]);
    memory_.setCost(second, kNever);
    if (isLast) {
      tail_ = both;
      tailPlace_ = first;
      memory_.setCost(first, kNever);
    } else {
      memory_.setSegment(first, both);
      memory_.setCost(first, cost);
      next_.set(first, next_[second]);
      before_.set(next_[first], first);
    }
    if (first != 0) memory_.setCost(before_[first], costOf(memory_.segment(before_[first]), both));
    --size_;
    return cost;
  }

  Memory memory_;       // of all but the last one, whose cost is kNever; costs of places that hold none are that as well
  int room_;
  int size_ = 0;
  int tailPlace_ = kNone;
  RaySegment tail_;     // the last one, most of what comes is merged into
  int group_ = kNone;   // whose samples are kept, as one
  RaySegment grouped_;
  float unseen_ = 0.0f;        // what costs no more, squared, is merged into the tail without a look at the others
  bool isTailRenewed_ = true;  // the cost of merging the last two is that of how they are
  PlaceList next_, before_;
};

using SegmentMerger = BasicSegmentMerger<OwnMergerMemory>;

/// What a ray has come to: its segments, near to far. Read as a merger is.
class SegmentList {
 public:
  static constexpr int kNone = -1;

  void clear() { size_ = 0; }
  void add(const RaySegment& segment) { segments_[size_++] = segment; }  ///< there is room for as many as mergers have
  template <class Merger>
  void take(const Merger& merger) {
    clear();
    for (int i = merger.first(); i != Merger::kNone; i = merger.behind(i)) add(merger[i]);
  }

  int size() const { return size_; }
  int first() const { return behind(-1); }
  int behind(int i) const { return i + 1 < size_ ? i + 1 : kNone; }
  const RaySegment& operator[](int i) const { return segments_[i]; }

 private:
  int size_ = 0;
  RaySegment segments_[kMostMergerRoom];
};

/// What marchRay gathers where segments are wanted beside the ray's light. Without a merger it gathers the light alone: a march that asks at each sample is as
/// fast as one compiled without, and half of the code.
template <class MarchPolicy, class Merger = SegmentMerger>
class SegmentedColor : public GatheredColor<MarchPolicy> {
 public:
  WARPSCOPE_HD SegmentedColor(Merger* segments, const RayLattice& lattice) : segments_(segments), lattice_(lattice) {}

  WARPSCOPE_HD void add(const ClassifiedSample& sample, const glm::vec3& color, float through) {
    GatheredColor<MarchPolicy>::add(sample, color, through);
    if (segments_ != nullptr) segments_->addStep({lattice_.border(sample.i), lattice_.border(sample.i + 1), sample.alpha, through, color}, sample.i);
  }
  WARPSCOPE_HD void add(const PointSample& sample, const glm::vec3& color, float through) {
    GatheredColor<MarchPolicy>::add(sample, color, through);
    if (segments_ != nullptr) segments_->add({sample.t, sample.t, sample.alpha, through, color});
  }

  static constexpr bool kIsToldOfGroups = Merger::kIsToldOfGroups;
  WARPSCOPE_HD static int endOfGroup(int i) { return (i / kGroupedSteps + 1) * kGroupedSteps; }
  WARPSCOPE_HD void endGroup(int i) {
    if (segments_ != nullptr) segments_->endGroup(i);
  }
  WARPSCOPE_HD bool wantsGroupToEnd() const { return segments_ != nullptr && segments_->wantsGroupToEnd(); }

 private:
  Merger* segments_;
  const RayLattice& lattice_;
};

}  // namespace warpscope
