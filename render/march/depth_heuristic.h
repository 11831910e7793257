// Which depth stands for a ray: every heuristic as a fold over the ray's samples, so that a ray may be marched in pieces.
// After Zellmann, Aumueller, Lang 2012 and Zellmann 2020; crossings are refined inside the step, which those do not do.
//
// A fold has a state per ray segment (default-constructed: the identity), `add` for the next sample that counts, and an associative
// `combine(front, back)`. A sample counts if its contribution alpha * T is at least the settings' `contribution`; only those reach a
// fold. T is known before folding: a back segment is folded with the transmittance of what lies in front of it.
//
// Heuristics that need the ray's end first (rel-threshold, en-ex-mean, median) are two folds: a ProfileFold over the whole ray, then a
// CrossingFold whose threshold it gives. Ties: the nearer sample wins.
#pragma once

#include "render/core/numeric.h"
#include "render/march/march_settings.h"

namespace warpscope {

/// A sample that counts. Distances are along the ray, volume units.
struct CountingSample {
  float t = 0.0f;              ///< centre of the step
  float ds = 0.0f;             ///< length of the step
  float alpha = 0.0f;          ///< opacity, corrected to the step
  float transmittance = 1.0f;  ///< T before the sample
  float accumulated = 0.0f;    ///< 1 - T, which float could not tell from T where little light is taken

  /// Behind what lets through that much; `through` is the same as a float, which a march has already: on a device,
  /// turning one into the other takes as long as ten multiplications.
  WARPSCOPE_HD static CountingSample behind(double transmittance, float through, float t, float ds, float alpha) {
    return {t, ds, alpha, through, static_cast<float>(1.0 - transmittance)};
  }
  WARPSCOPE_HD static CountingSample behind(double transmittance, float t, float ds, float alpha) {
    return behind(transmittance, static_cast<float>(transmittance), t, ds, alpha);
  }

  WARPSCOPE_HD float contribution() const { return alpha * transmittance; }
  /// Accumulated opacity before and after the sample: precise to 2^-23 relative to itself, however little light is taken.
  WARPSCOPE_HD float accumulatedBefore() const { return accumulated; }
  WARPSCOPE_HD float accumulatedAfter() const { return alpha >= 1.0f ? 1.0f : minOf(mulAdd(transmittance, alpha, accumulated), 1.0f); }
};

/// A depth, or none where no sample counted.
struct DepthResult {
  bool hasDepth = false;
  float depth = 0.0f;   ///< along the ray, volume units
  float spread = 0.0f;  ///< standard deviation of depth, where the heuristic knows it (expected); else 0
};

// What folds are off by, u = 2^-24, given the samples' places, lengths, opacities and the transmittance in double.
/// Gradient: contributions are a product of a float and a rounded transmittance, so that the sample found contributes
/// this much less than the largest, at most.
inline constexpr double kContributionError = 4.001 * 0x1p-24;
/// Crossings: where they are found, accumulated opacity is the threshold within this, relative to it. Opacities before
/// and after a step carry 1 and 2u, a threshold that is a share of the end's 3u, the fraction of the step what their
/// differences make of it. Then the place is rounded: by u of it and 2u of ds.
inline constexpr double kCrossingError = 9.001 * 0x1p-24;
/// Expected: for each sample and three besides, relative to the farthest one's distance, what the mean is off by: each
/// sample rounds the mean once, and weights carry a rounding for each sample before. The square of the spread is off by
/// twice that, times the distance from the first to the last: a spread that is nearly 0 beside the distance from the
/// eye has half its digits.
inline constexpr double kMeanErrorPerSample = 2.001 * 0x1p-24;

/// First and last sample that counts; the base of entrance, exit, midpoint. The first two are exact, the midpoint is
/// rounded once.
struct ExtentFold {
  bool any = false;
  float first = 0.0f;
  float last = 0.0f;

  WARPSCOPE_HD void add(const CountingSample& sample) {
    if (!any) first = sample.t;
    last = sample.t;
    any = true;
  }
  WARPSCOPE_HD static ExtentFold combine(const ExtentFold& front, const ExtentFold& back) {
    if (!front.any) return back;
    if (!back.any) return front;
    return {true, front.first, back.last};
  }
};

/// The sample with the largest key: its opacity (peak), which is exact, or its contribution (gradient), within
/// kContributionError.
template <bool kByContribution>
struct LargestFold {
  float key = kNone;
  float t = 0.0f;
  static constexpr float kNone = -1.0f;  ///< less than any sample's

  WARPSCOPE_HD void add(const CountingSample& sample) {
    const float candidate = kByContribution ? sample.contribution() : sample.alpha;
    if (!(candidate > key)) return;
    key = candidate;
    t = sample.t;
  }
  WARPSCOPE_HD static LargestFold combine(const LargestFold& front, const LargestFold& back) { return back.key > front.key ? back : front; }
  WARPSCOPE_HD DepthResult result() const { return {key >= 0.0f, t, 0.0f}; }
};

/// Where accumulated opacity reaches `threshold`, refined linearly inside the step, within kCrossingError; the last
/// sample if it never does.
struct CrossingFold {
  float threshold = 0.0f;  ///< a parameter, the same in every segment of a ray
  bool any = false;
  bool crossed = false;
  float t = 0.0f;  ///< the crossing, else the last sample so far

  WARPSCOPE_HD void add(const CountingSample& sample) {
    if (crossed) return;
    any = true;
    t = sample.t;
    const float after = sample.accumulatedAfter();
    if (!(after >= threshold)) return;
    crossed = true;
    // What does not count may have carried the accumulation over the threshold before this sample: then its near end is the place.
    const float before = sample.accumulatedBefore();
    const float rise = after - before;
    const float fraction = rise > 0.0f ? glm::clamp((threshold - before) / rise, 0.0f, 1.0f) : 0.0f;
    t += (fraction - 0.5f) * sample.ds;
  }
  WARPSCOPE_HD static CrossingFold combine(const CrossingFold& front, const CrossingFold& back) {
    CrossingFold whole = front.crossed || !back.any ? front : back;
    whole.threshold = maxOf(front.threshold, back.threshold);  // the identity has none
    return whole;
  }
  WARPSCOPE_HD DepthResult result() const { return {any, t, 0.0f}; }
};

/// Mean and spread of depth, weighted by contribution. Updating and combining after West 1979 and Chan, Golub, LeVeque
/// 1979, which do not subtract large sums; within kMeanErrorPerSample.
struct MomentsFold {
  float weight = 0.0f;
  float mean = 0.0f;
  float squares = 0.0f;  ///< sum of w * (t - mean)^2

  WARPSCOPE_HD void add(const CountingSample& sample) {
    const float w = sample.contribution();
    weight += w;
    const float delta = sample.t - mean;
    mean += delta * (w / weight);
    squares += w * delta * (sample.t - mean);
  }
  WARPSCOPE_HD static MomentsFold combine(const MomentsFold& front, const MomentsFold& back) {
    if (!(front.weight > 0.0f)) return back;
    if (!(back.weight > 0.0f)) return front;
    const float weight = front.weight + back.weight;
    const float delta = back.mean - front.mean;
    const float share = back.weight / weight;
    return {weight, front.mean + delta * share, front.squares + back.squares + delta * delta * front.weight * share};
  }
  WARPSCOPE_HD DepthResult result() const {
    return {weight > 0.0f, mean, weight > 0.0f ? std::sqrt(glm::max(squares, 0.0f) / weight) : 0.0f};
  }
};

/// What two-pass heuristics want to know of the whole ray.
struct ProfileFold {
  bool any = false;
  float alphaEntrance = 0.0f;
  float alphaExit = 0.0f;
  float accumulatedEnd = 0.0f;  ///< after the last sample that counts: the same whether marching stopped early or not

  WARPSCOPE_HD void add(const CountingSample& sample) {
    if (!any) alphaEntrance = sample.alpha;
    any = true;
    alphaExit = sample.alpha;
    accumulatedEnd = sample.accumulatedAfter();
  }
  WARPSCOPE_HD static ProfileFold combine(const ProfileFold& front, const ProfileFold& back) {
    if (!front.any) return back;
    if (!back.any) return front;
    return {true, front.alphaEntrance, back.alphaExit, back.accumulatedEnd};
  }
};

/// The first of two passes: the profile, and whether the second can be left out.
struct FirstPass {
  ProfileFold profile;
  CountingSample first;  ///< of those that count
  bool isAlone = true;   ///< it is the only one

  WARPSCOPE_HD void add(const CountingSample& sample) {
    if (profile.any)
      isAlone = false;
    else
      first = sample;
    profile.add(sample);
  }
  /// True if the ray's first sample decides: then `fold`, which has been started with the profile, has what all samples would have made of it.
  template <class Fold>
  WARPSCOPE_HD bool decides(Fold& fold) const {
    if (!profile.any) return true;
    Fold alone = fold;
    alone.add(first);
    if (!alone.crossed && !isAlone) return false;
    fold = alone;
    return true;
  }
};

// --- One type per heuristic: its fold, how to start it, how to read it. Two-pass ones say so and take the profile;
// those that the knob `threshold` turns have a member kTakesThreshold.

struct EntranceDepth {
  static constexpr bool kTwoPass = false;
  using Fold = ExtentFold;
  WARPSCOPE_HD static Fold start(float, const ProfileFold&) { return {}; }
  WARPSCOPE_HD static DepthResult result(const Fold& fold) { return {fold.any, fold.first, 0.0f}; }
};

struct ExitDepth {
  static constexpr bool kTwoPass = false;
  using Fold = ExtentFold;
  WARPSCOPE_HD static Fold start(float, const ProfileFold&) { return {}; }
  WARPSCOPE_HD static DepthResult result(const Fold& fold) { return {fold.any, fold.last, 0.0f}; }
};

struct MidpointDepth {
  static constexpr bool kTwoPass = false;
  using Fold = ExtentFold;
  WARPSCOPE_HD static Fold start(float, const ProfileFold&) { return {}; }
  WARPSCOPE_HD static DepthResult result(const Fold& fold) { return {fold.any, 0.5f * (fold.first + fold.last), 0.0f}; }
};

template <class FoldType>
struct OwnResultDepth {
  static constexpr bool kTwoPass = false;
  using Fold = FoldType;
  WARPSCOPE_HD static Fold start(float, const ProfileFold&) { return {}; }
  WARPSCOPE_HD static DepthResult result(const Fold& fold) { return fold.result(); }
};
using PeakDepth = OwnResultDepth<LargestFold<false>>;
using GradientDepth = OwnResultDepth<LargestFold<true>>;
using ExpectedDepth = OwnResultDepth<MomentsFold>;

struct ThresholdDepth {
  static constexpr bool kTwoPass = false;
  static constexpr bool kTakesThreshold = true;
  using Fold = CrossingFold;
  WARPSCOPE_HD static Fold start(float threshold, const ProfileFold&) { return {threshold}; }
  WARPSCOPE_HD static DepthResult result(const Fold& fold) { return fold.result(); }
};

struct RelThresholdDepth {
  static constexpr bool kTwoPass = true;
  static constexpr bool kTakesThreshold = true;
  using Fold = CrossingFold;
  WARPSCOPE_HD static Fold start(float threshold, const ProfileFold& ray) { return {threshold * ray.accumulatedEnd}; }
  WARPSCOPE_HD static DepthResult result(const Fold& fold) { return fold.result(); }
};

struct EnExMeanDepth {
  static constexpr bool kTwoPass = true;
  using Fold = CrossingFold;
  WARPSCOPE_HD static Fold start(float, const ProfileFold& ray) { return {0.5f * (ray.alphaEntrance + ray.alphaExit)}; }
  WARPSCOPE_HD static DepthResult result(const Fold& fold) { return fold.result(); }
};

struct MedianDepth {
  static constexpr bool kTwoPass = true;
  using Fold = CrossingFold;
  WARPSCOPE_HD static Fold start(float, const ProfileFold& ray) { return {0.5f * ray.accumulatedEnd}; }
  WARPSCOPE_HD static DepthResult result(const Fold& fold) { return fold.result(); }
};

/// Any heuristic of one pass, or of two, chosen when it is used: for marches whose samples are dear enough that a choice at each does not matter,
/// and that would be compiled once a heuristic otherwise. The same folds.
template <bool kTwo>
struct AnyDepth {
  static constexpr bool kTwoPass = kTwo;
  Heuristic heuristic = kTwo ? Heuristic::median : Heuristic::gradient;

  /// The one of the other folds that the heuristic has, in as much memory as the largest of them.
  struct Fold {
    Heuristic heuristic = Heuristic::gradient;
    bool any = false;
    bool crossed = false;
    float values[3] = {0.0f, 0.0f, 0.0f};

    WARPSCOPE_HD void add(const CountingSample& sample) {
      if constexpr (kTwo) {
        addToCrossing(sample);
      } else {
        switch (heuristic) {
          case Heuristic::threshold: addToCrossing(sample); return;
          case Heuristic::peak: addToLargest<false>(sample); return;
          case Heuristic::gradient: addToLargest<true>(sample); return;
          case Heuristic::expected: {
            MomentsFold fold{values[0], values[1], values[2]};
            fold.add(sample);
            values[0] = fold.weight, values[1] = fold.mean, values[2] = fold.squares;
            return;
          }
          default: {
            ExtentFold fold{any, values[0], values[1]};
            fold.add(sample);
            any = fold.any, values[0] = fold.first, values[1] = fold.last;
            return;
          }
        }
      }
    }

   private:
    WARPSCOPE_HD void addToCrossing(const CountingSample& sample) {
      CrossingFold fold{values[2], any, crossed, values[0]};
      fold.add(sample);
      any = fold.any, crossed = fold.crossed, values[0] = fold.t;
    }
    template <bool kByContribution>
    WARPSCOPE_HD void addToLargest(const CountingSample& sample) {
      LargestFold<kByContribution> fold{values[0], values[1]};
      fold.add(sample);
      any = true, values[0] = fold.key, values[1] = fold.t;
    }
  };

  WARPSCOPE_HD Fold start(float threshold, const ProfileFold& ray) const {
    Fold fold{heuristic};
    switch (heuristic) {
      case Heuristic::threshold: fold.values[2] = ThresholdDepth::start(threshold, ray).threshold; break;
      case Heuristic::relThreshold: fold.values[2] = RelThresholdDepth::start(threshold, ray).threshold; break;
      case Heuristic::enExMean: fold.values[2] = EnExMeanDepth::start(threshold, ray).threshold; break;
      case Heuristic::median: fold.values[2] = MedianDepth::start(threshold, ray).threshold; break;
      case Heuristic::peak:
      case Heuristic::gradient: fold.values[0] = LargestFold<true>::kNone; break;
      default: break;
    }
    return fold;
  }
  WARPSCOPE_HD DepthResult result(const Fold& fold) const {
    const float(&values)[3] = fold.values;
    if constexpr (kTwo) return {fold.any, values[0], 0.0f};
    const ExtentFold extent{fold.any, values[0], values[1]};
    const MomentsFold moments{values[0], values[1], values[2]};
    switch (heuristic) {
      case Heuristic::entrance: return EntranceDepth::result(extent);
      case Heuristic::exit: return ExitDepth::result(extent);
      case Heuristic::midpoint: return MidpointDepth::result(extent);
      case Heuristic::expected: return moments.result();
      case Heuristic::threshold: return {fold.any, values[0], 0.0f};
      default: return {fold.any, values[1], 0.0f};
    }
  }
};

/// Calls `f` with the heuristic's type.
template <class F>
decltype(auto) visitHeuristic(Heuristic heuristic, F&& f) {
  switch (heuristic) {
    case Heuristic::entrance: return f(EntranceDepth{});
    case Heuristic::exit: return f(ExitDepth{});
    case Heuristic::midpoint: return f(MidpointDepth{});
    case Heuristic::threshold: return f(ThresholdDepth{});
    case Heuristic::peak: return f(PeakDepth{});
    case Heuristic::gradient: return f(GradientDepth{});
    case Heuristic::relThreshold: return f(RelThresholdDepth{});
    case Heuristic::enExMean: return f(EnExMeanDepth{});
    case Heuristic::median: return f(MedianDepth{});
    case Heuristic::expected: break;
  }
  return f(ExpectedDepth{});
}

/// Calls `f` with the heuristic as one of the two types for any.
template <class F>
decltype(auto) visitAnyHeuristic(Heuristic heuristic, F&& f) {
  const bool isTwoPass = visitHeuristic(heuristic, []<class Depth>(Depth) { return Depth::kTwoPass; });
  if (isTwoPass) return f(AnyDepth<true>{heuristic});
  return f(AnyDepth<false>{heuristic});
}

}  // namespace warpscope
