// One ray through a volume, front to back: the loop that the CPU and the GPU share. Where the values come from is the source's business.
// Emission and absorption, front-to-back compositing with early termination (Levoy 1990; Max 1995).
#pragma once

#include <bit>
#include <cstdint>

#include "render/core/counters.h"
#include "render/core/ray.h"
#include "render/core/transfer_table.h"
#include "render/march/depth_heuristic.h"
#include "render/march/lattice.h"
#include "render/march/light.h"
#include "render/march/march_arithmetic.h"

namespace warpscope {

/// What a ray has gathered so far; carried from one segment of a ray to the next. By which arithmetic: march_arithmetic.h.
template <class MarchPolicy>
class GatheredColor : public MarchPolicy::LightSum {
 public:
  using March = MarchPolicy;
  static constexpr bool kWantsColor = true;

  /// Takes a sample, whose colour as it is seen (times its opacity) is seen through `through`.
  WARPSCOPE_HD void add(const ClassifiedSample& sample, const glm::vec3& color, float through) { MarchPolicy::LightSum::add(sample.i, color, through); }
  WARPSCOPE_HD glm::vec4 premultiplied() const { return {glm::vec3(this->color()), transmittance.opacity()}; }

  typename March::Transmittance transmittance;
};
using RayColor = GatheredColor<StableMarch>;

/// As RayColor, for a pass that wants depths only.
struct RayOpacity {
  using March = StableMarch;
  static constexpr bool kWantsColor = false;

  Transmittance transmittance;

  WARPSCOPE_HD void add(const ClassifiedSample&, const glm::vec3&, float) {}
};

/// A ray, and where along it the volume is sampled.
struct RayPath {
  Ray ray;
  RayLattice lattice;
};

/// Which samples count, and where rays end.
struct RayLimits {
  float contribution = 0.0f;  ///< least contribution of a sample that counts
  float stopBelow = 0.0f;     ///< transmittance below which a ray ends; 0: never. What follows cannot count as long as
                              ///< stopBelow <= contribution
};

/// Place of the lowest bit that is set; `bits` is not 0.
WARPSCOPE_HD inline int lowestBit(uint32_t bits) {
#if defined(__CUDA_ARCH__)
  return __ffs(static_cast<int>(bits)) - 1;
#else
  return std::countr_zero(bits);
#endif
}

/// Batches of sources that look at as many samples as a thread of a device may.
inline constexpr int kSmallBatch = 2;

/// What marchRay gathers is off by, relative to itself, given its samples' opacities and colours: the opacity of
/// samples of 1e-9 or more by a rounding of the result and 2^-53 for each sample; colours by one of the sample's light,
/// one of the transmittance, those of a block's 16 sums, two of a partial step and one of the result.
inline constexpr double kMarchedOpacityError = 4 * 0x1p-24;
inline constexpr double kMarchedColorError = 21.001 * 0x1p-24;

/// Whether what gathers is to be told where groups of samples end, as a SegmentedColor may be: groups begin and end at the same steps of all lattices, so that rays beside each other, which a
/// device marches together, end them together. It has, then,
///   int endOfGroup(int i)      where the group of sample i ends
///   void endGroup(int i)       ends the one in front of sample i, if there is one
///   bool wantsGroupToEnd()     whether the one that there is ends before another sample is added
template <class Gathered>
inline constexpr bool kIsToldOfGroups = requires { requires Gathered::kIsToldOfGroups; };
template <class Gathered>
WARPSCOPE_HD inline bool wantsGroupToEnd(const Gathered& ray) {
  if constexpr (kIsToldOfGroups<Gathered>)
    return ray.wantsGroupToEnd();
  else
    return false;
}

/// Marches samples [begin, end) of the path's lattice.
///
/// `Source` tells what the samples look like, up to Source::kBatch at a time:
///   int skip(int i)                first sample >= i that may be visible
///   uint32_t classify(int i, int n)   directly after skip() gave i: looks at samples i .. i + n - 1, n <= kBatch <= 32,
///                                  none of them the lattice's last; bit k is set if the k-th has any opacity
///   bool classifyLast()            looks at the lattice's last sample alone; true if it has any opacity
///   float alpha(int k)             opacity of the k-th that was looked at, corrected to the lattice's dt
///   float unitAlpha(int k)         the same over one unit of volume space
///   glm::vec3 color(int k)         its colour times that opacity
///   float t(int k)                 where it lies; for an arithmetic that does not place samples by their index alone
/// `light` turns that colour into the one that is seen: light.h. `ray` gathers; a RayColor, a RayOpacity or a RayPiece
/// (ray_state.h), or a SegmentedColor (ray_segments.h). `sink` is called with a CountingSample for every sample whose contribution is at least the limits',
/// near to far; if it returns false, the ray ends there, before that sample's light is added. Ends where transmittance
/// falls below the limits'; `ray` must not come with less.
template <class Source, class Light, class Gathered, class Sink>
WARPSCOPE_HD inline void marchRay(const RayPath& path, int begin, int end, Source& source, const Light& light,
                                  const RayLimits& limits, Gathered& ray, Sink&& sink) {
  using March = typename Gathered::March;
  const RayLattice& lattice = path.lattice;
  const auto wholePlaceOf = [&](int i, int k) {
    if constexpr (March::kPlacesByIndex)
      return lattice.tOfWholeStep(i);
    else
      return source.t(k);
  };
  float through = ray.transmittance.value();
  LightOnSource<Light, Source> lighting{light};
  // False where the ray ends. `k`: the sample's place among those that the source looked at.
  const auto pass = [&](const ClassifiedSample& sample, const auto& shade) {
    glm::vec3 color(0.0f);
    if constexpr (Gathered::kWantsColor) color = shade(sample);
    if (through * sample.alpha >= limits.contribution &&
        !sink(CountingSample::behind(ray.transmittance.exact(), through, sample.t, sample.ds, sample.alpha)))
      return false;
    ray.add(sample, color, through);
    ray.transmittance.pass(sample.alpha);
    through = ray.transmittance.value();
    const bool ends = through < limits.stopBelow;
    if (ends) WARPSCOPE_COUNT(earlyEnds, 1);
    return !ends;
  };

  const int last = lattice.count - 1;  // may be a part of a step: dealt with for itself, so that the others need not ask
  const int wholeEnd = end <= last ? end : last;
  int i = source.skip(begin);
  static_assert(!kIsToldOfGroups<Gathered> || Source::kBatch == 1);  // it is asked between samples whether its group is to end
  // Whether there is more. endGroup() stands here alone: it is inlined, and large.
  const auto goesOn = [&] {
    if constexpr (kIsToldOfGroups<Gathered>) ray.endGroup(i < end ? i : end);
    return i < wholeEnd;
  };
  while (goesOn()) {
    int stop = wholeEnd;
    if constexpr (kIsToldOfGroups<Gathered>) stop = minOf(Gathered::endOfGroup(i), wholeEnd);
    do {
      const int n = stop - i < Source::kBatch ? stop - i : Source::kBatch;
      uint32_t visible = source.classify(i, n);
      if constexpr (Gathered::kWantsColor)
        if (visible != 0) lighting.look(path, source, i, visible);
      const auto passAt = [&](int k) {
        return pass({i + k, wholePlaceOf(i + k, k), lattice.dt, source.alpha(k), source.color(k)},
                    [&](const ClassifiedSample& sample) { return lighting.shade(sample, path.ray, source, k); });
      };
      if constexpr (Source::kBatch <= kSmallBatch) {
        for (int k = 0; k < Source::kBatch; ++k)  // unrolled, so that what the source knows of them stays in registers
          if ((visible >> k & 1u) != 0 && !passAt(k)) return;
      } else {
        for (; visible != 0; visible &= visible - 1)
          if (!passAt(lowestBit(visible))) return;
      }
      i = source.skip(i + n);
    } while (i < stop && !wantsGroupToEnd(ray));
  }
  if (i < end && source.classifyLast()) {
    const float ds = lattice.stepLength(last);
    const float alpha = March::partOfStep(source, ds, lattice.dt);
    pass({last, lattice.t(last), ds, alpha, source.color(0) * (alpha / source.alpha(0))},
         [&](const ClassifiedSample& sample) { return light.shade(sample, path.ray, source, 0); });
  }
}

}  // namespace warpscope
