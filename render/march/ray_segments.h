// A ray's samples merged into segments: stretches of it that are taken as homogeneous, near to far, not overlapping. For host and device.
// Volumetric depth images: Frey, Sadlo, Ertl 2013; merging neighbours bottom-up: Keogh et al. 2001 ("segmenting time series"). What a merge costs is ours.
//
// A segment has the light and the opacity of all the samples that became it, as seen from the ray's beginning with nothing in front: segments over one another
// are the ray (Porter, Duff 1984), however they were merged. What is lost is where within the segment they were.
//
// The cost of merging two neighbours is what another camera would see of that: light is moved along the ray, and from an angle beside it.
//   moved = h * (|density_a - density_b| / (density_a + density_b) * distance of the centres + gap)
//   colour = h * distance of the centres * difference of the straight colours, the largest of three channels
// with h the harmonic mean of what the two contribute to the picture (transmittance in front times opacity): what hardly contributes may go anywhere. Where both
// are equally dense, no gap lies between and colours are alike, nothing is lost. Density is opacity by length, the opacity a as a / (1 - a / 2), which is the
// extinction's integral up to a^3 / 12 and needs no logarithm.
#pragma once

#include "render/march/march.h"

namespace warpscope {

/// The most that settings may ask for.
inline constexpr int kMaxRaySegments = static_cast<int>(kSegmentsRange.highest);

/// A stretch of a ray. Distances along the ray from its beginning, volume units.
struct RaySegment {
  float begin = 0.0f, end = 0.0f;
  float opacity = 0.0f;   ///< of it alone
  float through = 1.0f;   ///< transmittance of what lies in front
  glm::vec3 color{0.0f};  ///< linear, premultiplied, as if nothing lay in front

  WARPSCOPE_HD float contribution() const { return through * opacity; }
  WARPSCOPE_HD float center() const { return 0.5f * (begin + end); }
  /// Optical depth by length, about; 0 where there is no length, as with surfaces: those beside each other are told apart by the gap between them.
  WARPSCOPE_HD float density() const {
    const float length = end - begin;
    return length > 0.0f ? opacity / ((1.0f - 0.5f * opacity) * length) : 0.0f;
  }
};

/// Both as one. `back` follows `front`.
WARPSCOPE_HD inline RaySegment merged(const RaySegment& front, const RaySegment& back) {
  const float rest = 1.0f - front.opacity;
  RaySegment both;
  both.begin = front.begin;
  both.end = back.end;
  both.opacity = mulAdd(rest, back.opacity, front.opacity);
  both.through = front.through;
  for (int channel = 0; channel < 3; ++channel) both.color[channel] = mulAdd(rest, back.color[channel], front.color[channel]);
  return both;
}

/// What merging the two would cost; 0 or more.
WARPSCOPE_HD inline float mergeCost(const RaySegment& front, const RaySegment& back) {
  const float a = front.contribution(), b = back.contribution();
  if (!(a > 0.0f) || !(b > 0.0f)) return 0.0f;
  const float ofBoth = a * b / (a + b);
  const float distance = back.center() - front.center(), gap = maxOf(back.begin - front.end, 0.0f);
  const float densityA = front.density(), densityB = back.density(), densities = densityA + densityB;
  const float unlike = densities > 0.0f ? absOf(densityA - densityB) / densities : 0.0f;
  const glm::vec3 colorA = front.color * (1.0f / front.opacity), colorB = back.color * (1.0f / back.opacity);
  const float otherColor = maxOf(maxOf(absOf(colorA.x - colorB.x), absOf(colorA.y - colorB.y)), absOf(colorA.z - colorB.z));
  return ofBoth * (distance * (unlike + otherColor) + gap);
}

/// Segments of the ray that is marched, few at any time: when there is no room for another, the two are merged for which that costs least.
class SegmentMerger {
 public:
  /// Segments that are kept until the ray has ended.
  static constexpr int kRoom = 16;

  WARPSCOPE_HD int size() const { return size_; }
  WARPSCOPE_HD const RaySegment& operator[](int i) const { return segments_[i]; }
  WARPSCOPE_HD void clear() { size_ = 0; }

  /// What comes next along the ray.
  WARPSCOPE_HD void add(const RaySegment& next) {
    if (size_ > 0) {
      const float cost = mergeCost(segments_[size_ - 1], next);
      if (size_ == kRoom) {
        const int cheapest = cheapestPair();
        if (!(costs_[cheapest] < cost)) {
          segments_[size_ - 1] = merged(segments_[size_ - 1], next);
          costs_[size_ - 2] = mergeCost(segments_[size_ - 2], segments_[size_ - 1]);
          return;
        }
        mergePair(cheapest);
        // The last one may have become another.
        costs_[size_ - 1] = cheapest == size_ - 1 ? mergeCost(segments_[size_ - 1], next) : cost;
      } else {
        costs_[size_ - 1] = cost;
      }
    }
    segments_[size_++] = next;
  }

  /// Merges until no more than `most`, at least 1, are left.
  WARPSCOPE_HD void reduceTo(int most) {
    while (size_ > most) mergePair(cheapestPair());
  }

 private:
  /// The first of the two that cost least; of equal ones the nearest.
  WARPSCOPE_HD int cheapestPair() const {
    int cheapest = 0;
    for (int i = 1; i + 1 < size_; ++i)
      if (costs_[i] < costs_[cheapest]) cheapest = i;
    return cheapest;
  }

  WARPSCOPE_HD void mergePair(int first) {
    segments_[first] = merged(segments_[first], segments_[first + 1]);
    --size_;
    for (int i = first + 1; i < size_; ++i) segments_[i] = segments_[i + 1];
    for (int i = first; i + 1 < size_; ++i) costs_[i] = costs_[i + 1];
    if (first > 0) costs_[first - 1] = mergeCost(segments_[first - 1], segments_[first]);
    if (first + 1 < size_) costs_[first] = mergeCost(segments_[first], segments_[first + 1]);
  }

  int size_ = 0;
  RaySegment segments_[kRoom];
  float costs_[kRoom];  // of merging each with the next
};

/// What marchRay gathers where segments are wanted beside the ray's light.
template <class MarchPolicy>
class SegmentedColor : public GatheredColor<MarchPolicy> {
 public:
  WARPSCOPE_HD explicit SegmentedColor(SegmentMerger& segments) : segments_(segments) {}

  WARPSCOPE_HD void add(const ClassifiedSample& sample, const glm::vec3& color, float through) {
    GatheredColor<MarchPolicy>::add(sample, color, through);
    segments_.add({sample.t - 0.5f * sample.ds, sample.t + 0.5f * sample.ds, sample.alpha, through, color});
  }

 private:
  SegmentMerger& segments_;
};

}  // namespace warpscope
