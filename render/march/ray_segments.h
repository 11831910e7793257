// A ray's samples merged into segments: stretches of it that are taken as homogeneous, near to far, not overlapping. For host and device.
// Volumetric depth images: Frey, Sadlo, Ertl 2013; merging neighbours bottom-up: Keogh et al. 2001 ("segmenting time series"). What a merge costs is ours.
//
// A segment has the light and the opacity of all the samples that became it, as seen from the ray's beginning with nothing in front: segments over one another
// are the ray (Porter, Duff 1984), however they were merged. What is lost is where within the segment they were.
//
// The cost of merging two neighbours is how far light is moved along the ray, which from an angle is beside it, and how much of it changes colour:
//   moved: the integral along the ray of how much of the optical depth in front of a place changes (the earth mover's distance of both distributions: Rubner,
//     Tomasi, Guibas 1998), times the light that both send for each unit of it. Of two that lie side by side, equally dense, it is 0; a gap between them
//     counts by all that it is filled with, not by what lies on its smaller side. Optical depth is taken as a / (1 - a / 2), a being the opacity: right up to
//     a^3 / 12, and without a logarithm.
//   recoloured: a b / (a + b) times the difference of the straight colours (the largest of three channels) times half of the merged segment's length, a and b
//     being what both contribute to the picture: transmittance in front times opacity.
// Both are light times length.
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

/// `front` becomes both. `back` follows it.
WARPSCOPE_HD inline void mergeInto(RaySegment& front, const RaySegment& back) {
  const float rest = 1.0f - front.opacity;
  front.end = back.end;
  front.opacity = mulAdd(rest, back.opacity, front.opacity);
  for (int channel = 0; channel < 3; ++channel) front.color[channel] = mulAdd(rest, back.color[channel], front.color[channel]);
}

/// What merging two would cost, as a fraction: what is compared with another cost needs no division.
struct MergeCost {
  float over = 0.0f, under = 1.0f;

  WARPSCOPE_HD float value() const { return over / under; }
  WARPSCOPE_HD bool isAtMost(float cost) const { return over <= cost * under; }
};

/// What merging the two would cost; 0 or more.
WARPSCOPE_HD inline MergeCost mergeCost(const RaySegment& front, const RaySegment& back) {
  const float light = front.contribution() + back.contribution(), length = back.end - front.begin;
  // Optical depths, about, in a unit in which they need no division.
  const float depthA = front.opacity * mulAdd(back.opacity, -0.5f, 1.0f), depthB = back.opacity * mulAdd(front.opacity, -0.5f, 1.0f), depth = depthA + depthB;
  const float under = depth * light;
  if (!(front.contribution() > 0.0f) || !(back.contribution() > 0.0f) || !(length > 0.0f) || !(under > 0.0f)) return {};
  const float lengthA = front.end - front.begin, lengthB = back.end - back.begin, gap = back.begin - front.end;
  float moved = 0.5f * absOf(mulAdd(depthA, lengthB, -(depthB * lengthA)));
  if (gap > 0.0f) {
    // What is in front of a place, before less after: at the gap's beginning and at its end.
    const float density = depth / length, atGap = mulAdd(density, -lengthA, depthA), behindGap = mulAdd(density, lengthB, -depthB);
    const float first = absOf(atGap), second = absOf(behindGap), both = first + second;
    moved = mulAdd(atGap * behindGap < 0.0f ? 0.5f * mulAdd(first, first, second * second) / both : 0.5f * both, gap,
                   0.5f * mulAdd(first, lengthA, second * lengthB));
  }
  float otherColor = 0.0f;
  for (int channel = 0; channel < 3; ++channel)
    otherColor = maxOf(otherColor, absOf(front.color[channel] * back.opacity - back.color[channel] * front.opacity));
  return {mulAdd(moved, light * light, front.through * back.through * otherColor * (0.5f * length) * depth), under};
}

/// Places of a merger at most.
inline constexpr int kMostMergerRoom = 16;

/// Segments that are kept of a ray until it has ended, where `most` are wanted of it. A device has the less room for rays the more each holds; twice as many as are
/// wanted measured as good as four times (PSNR within 0.1 dB from every angle), so that there are two sizes.
WARPSCOPE_HD constexpr int mergerRoomFor(int most) { return most <= 4 ? 8 : kMostMergerRoom; }

/// Where a merger keeps what it holds: by default in itself. Places for segments, and for what merging each with the one behind it costs.
class OwnMergerMemory {
 public:

  WARPSCOPE_HD RaySegment segment(int i) const { return segments_[i]; }
  WARPSCOPE_HD void setSegment(int i, const RaySegment& segment) { segments_[i] = segment; }
  WARPSCOPE_HD uint32_t cost(int i) const { return costs_[i]; }
  WARPSCOPE_HD void setCost(int i, uint32_t cost) { costs_[i] = cost; }

 private:
  RaySegment segments_[kMostMergerRoom];
  uint32_t costs_[kMostMergerRoom];
};

/// The order of up to 16 places, four bits each: in a register, where an array that is indexed would be in memory.
class PlaceList {
 public:
  WARPSCOPE_HD int operator[](int i) const { return static_cast<int>(bits_ >> (4 * i) & 15); }
  WARPSCOPE_HD void set(int i, int place) { bits_ = (bits_ & ~(uint64_t{15} << (4 * i))) | static_cast<uint64_t>(place) << (4 * i); }

 private:
  uint64_t bits_ = 0;
};

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
    tailPlace_ = kNone;
    lastMerged_ = 0.0f;
    isTailRenewed_ = true;
    for (int i = 0; i < room_; ++i) memory_.setCost(i, kNever);
  }

  /// Becomes what `other` is, which has as much room and keeps what it holds elsewhere.
  template <class Other>
  WARPSCOPE_HD void take(const BasicSegmentMerger<Other>& other) {
    size_ = other.size_;
    tailPlace_ = other.tailPlace_;
    tail_ = other.tail_;
    lastMerged_ = other.lastMerged_;
    isTailRenewed_ = other.isTailRenewed_;
    next_ = other.next_;
    before_ = other.before_;
    for (int i = 0; i < room_; ++i) memory_.setCost(i, other.memory_.cost(i));
    for (int i = first(); i != kNone && i != tailPlace_; i = behind(i)) memory_.setSegment(i, other.memory_.segment(i));
  }

  WARPSCOPE_HD int size() const { return size_; }
  /// The nearest, and the one behind one; kNone if there is none.
  WARPSCOPE_HD int first() const { return size_ > 0 ? 0 : kNone; }  // nothing is merged into what lies behind it
  WARPSCOPE_HD int behind(int i) const { return i == tailPlace_ ? kNone : next_[i]; }
  WARPSCOPE_HD RaySegment operator[](int i) const { return i == tailPlace_ ? tail_ : memory_.segment(i); }

  /// What comes next along the ray.
  WARPSCOPE_HD void add(const RaySegment& next) {
    int place = size_;
    if (size_ > 0) {
      const MergeCost withNext = mergeCost(tail_, next);
      // What costs no more than the last merge is merged without a look at the others, which cost no less then: along smooth rays nearly every sample.
      if (size_ == room_ && withNext.isAtMost(lastMerged_)) return mergeIntoTail(next);
      uint32_t cost = bitsOfCost(withNext.value());
      if (size_ == room_) {
        renewTail();
        const int cheapest = cheapestPair();
        const uint32_t least = memory_.cost(cheapest);
        if (cost <= least) {
          lastMerged_ = withNext.value();
          return mergeIntoTail(next);
        }
        lastMerged_ = costOfBits(least);
        const bool changesTail = next_[cheapest] == tailPlace_;
        place = mergePair(cheapest);
        if (changesTail) cost = bitsOfCost(mergeCost(tail_, next).value());
      }
      memory_.setSegment(tailPlace_, tail_);
      memory_.setCost(tailPlace_, cost);
      next_.set(tailPlace_, place);
      before_.set(place, tailPlace_);
    }
    memory_.setCost(place, kNever);
    tail_ = next;
    tailPlace_ = place;
    ++size_;
  }

  /// Merges until no more than `most`, at least 1, are left.
  WARPSCOPE_HD void reduceTo(int most) {
    if (size_ > most) renewTail();
    while (size_ > most) mergePair(cheapestPair());
  }

 private:
  template <class>
  friend class BasicSegmentMerger;
  static constexpr uint32_t kNever = 0xffffffffu;

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
    for (int eight = 0; eight < room_; eight += 8)
      for (int i = eight; i < eight + 8; ++i) {
        const uint32_t cost = memory_.cost(i);
        cheapest = cost < least ? i : cheapest;
        least = cost < least ? cost : least;
      }
    return cheapest;
  }

  WARPSCOPE_HD void renewCost(int i) { memory_.setCost(i, bitsOfCost(mergeCost(memory_.segment(i), (*this)[next_[i]]).value())); }

  WARPSCOPE_HD void mergeIntoTail(const RaySegment& next) {
    mergeInto(tail_, next);
    isTailRenewed_ = false;
  }

  /// What merging the last two costs, if the last one has grown.
  WARPSCOPE_HD void renewTail() {
    if (!isTailRenewed_ && size_ > 1) renewCost(before_[tailPlace_]);
    isTailRenewed_ = true;
  }

  /// Returns the place that has become free.
  WARPSCOPE_HD int mergePair(int first) {
    const int second = next_[first];
    RaySegment both = memory_.segment(first);
    mergeInto(both, (*this)[second]);
    memory_.setCost(second, kNever);
    if (second == tailPlace_) {
      tail_ = both;
      tailPlace_ = first;
      memory_.setCost(first, kNever);
    } else {
      memory_.setSegment(first, both);
      next_.set(first, next_[second]);
      before_.set(next_[first], first);
      renewCost(first);
    }
    if (first != 0) renewCost(before_[first]);
    --size_;
    return second;
  }

  Memory memory_;       // of all but the last one, whose cost is kNever; costs of places that hold none are that as well
  int room_;
  int size_ = 0;
  int tailPlace_ = kNone;
  RaySegment tail_;     // the last one, most of what comes is merged into
  float lastMerged_ = 0.0f;    // what the last merge but those into the tail cost
  bool isTailRenewed_ = true;  // the cost of merging the last two is that of how they are
  PlaceList next_, before_;
};

using SegmentMerger = BasicSegmentMerger<OwnMergerMemory>;

/// What marchRay gathers where segments are wanted beside the ray's light. Without a merger it gathers the light alone: a march that asks at each sample is as
/// fast as one compiled without, and half of the code.
template <class MarchPolicy, class Merger = SegmentMerger>
class SegmentedColor : public GatheredColor<MarchPolicy> {
 public:
  WARPSCOPE_HD SegmentedColor(Merger* segments, const RayLattice& lattice) : segments_(segments), lattice_(lattice) {}

  WARPSCOPE_HD void add(const ClassifiedSample& sample, const glm::vec3& color, float through) {
    GatheredColor<MarchPolicy>::add(sample, color, through);
    if (segments_ == nullptr) return;
    const bool isStep = sample.ds > 0.0f;  // else a surface, or a value without length
    segments_->add({isStep ? lattice_.border(sample.i) : sample.t, isStep ? lattice_.border(sample.i + 1) : sample.t, sample.alpha, through, color});
  }

 private:
  Merger* segments_;
  const RayLattice& lattice_;
};

}  // namespace warpscope
