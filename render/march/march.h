// One ray through a volume, front to back: the loop that the CPU and the GPU share. Where the values come from is the source's business.
// Emission and absorption, front-to-back compositing with early termination (Levoy 1990; Max 1995).
#pragma once

#include <bit>
#include <cstdint>

#include "render/core/ray.h"
#include "render/core/transfer_table.h"
#include "render/march/depth_heuristic.h"
#include "render/march/lattice.h"
#include "render/march/light.h"
#include "render/march/transmittance.h"

namespace warpscope {

/// Light that a ray has gathered: a sum of sums. It is added up in float over a block of the lattice's samples, blocks
/// in double, for the same reason as transmittance. Blocks are those of the lattice, so that it does not matter in
/// which pieces a ray is marched.
class LightSum {
 public:
  /// Takes the light of the lattice's i-th sample, whose colour (times its opacity) is seen through `transmittance`.
  WARPSCOPE_HD void add(int i, const glm::vec3& color, float through) {
    if (i >> kBlockBits != block_) {
      sum_ += glm::dvec3(ofBlock_);
      ofBlock_ = glm::vec3(0.0f);
      block_ = i >> kBlockBits;
    }
    for (int channel = 0; channel < 3; ++channel) ofBlock_[channel] = mulAdd(through, color[channel], ofBlock_[channel]);
  }
  WARPSCOPE_HD glm::dvec3 color() const { return sum_ + glm::dvec3(ofBlock_); }  ///< linear, premultiplied

 private:
  static constexpr int kBlockBits = 4;

  glm::dvec3 sum_{0.0};
  glm::vec3 ofBlock_{0.0f};
  int block_ = 0;
};

/// What a ray has gathered so far; carried from one segment of a ray to the next.
class RayColor : public LightSum {
 public:
  static constexpr bool kWantsColor = true;

  WARPSCOPE_HD glm::vec4 premultiplied() const { return {glm::vec3(color()), transmittance.opacity()}; }

  Transmittance transmittance;
};

/// As RayColor, for a pass that wants depths only.
struct RayOpacity {
  static constexpr bool kWantsColor = false;

  Transmittance transmittance;

  WARPSCOPE_HD void add(int, const glm::vec3&, float) {}
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

/// What marchRay gathers is off by, relative to itself, given its samples' opacities and colours: the opacity of
/// samples of 1e-9 or more by a rounding of the result and 2^-53 for each sample; colours by one of the sample's light,
/// one of the transmittance, those of a block's 16 sums, two of a partial step and one of the result.
inline constexpr double kMarchedOpacityError = 4 * 0x1p-24;
inline constexpr double kMarchedColorError = 21.001 * 0x1p-24;

/// Marches samples [begin, end) of the path's lattice.
///
/// `Source` tells what the samples look like, up to Source::kBatch at a time:
///   int skip(int i)                first sample >= i that may be visible
///   uint32_t classify(int i, int n)   looks at samples i .. i + n - 1, n <= kBatch <= 32, none of them
///                                  the lattice's last; bit k is set if the k-th has any opacity
///   bool classifyLast()            looks at the lattice's last sample alone; true if it has any opacity
///   float alpha(int k)             opacity of the k-th that was looked at, corrected to the lattice's dt
///   float unitAlpha(int k)         the same over one unit of volume space
///   glm::vec3 color(int k)         its colour times that opacity
/// `light` turns that colour into the one that is seen: light.h. `ray` gathers; a RayColor, a RayOpacity or a RayPiece
/// (ray_state.h). `sink` is called with a CountingSample for every sample whose contribution is at least the limits',
/// near to far; if it returns false, the ray ends there, before that sample's light is added. Ends where transmittance
/// falls below the limits'; `ray` must not come with less.
template <class Source, class Light, class Gathered, class Sink>
WARPSCOPE_HD inline void marchRay(const RayPath& path, int begin, int end, Source& source, const Light& light,
                                  const RayLimits& limits, Gathered& ray, Sink&& sink) {
  const RayLattice& lattice = path.lattice;
  float through = ray.transmittance.value();
  // False where the ray ends. `k`: the sample's place among those that the source looked at.
  const auto pass = [&](int k, const ClassifiedSample& sample) {
    glm::vec3 color(0.0f);
    if constexpr (Gathered::kWantsColor) color = light.shade(sample, path.ray, source, k);
    if (through * sample.alpha >= limits.contribution &&
        !sink(CountingSample::behind(ray.transmittance.exact(), sample.t, sample.ds, sample.alpha)))
      return false;
    ray.add(sample.i, color, through);
    ray.transmittance.pass(sample.alpha);
    through = ray.transmittance.value();
    return !(through < limits.stopBelow);
  };

  const int last = lattice.count - 1;  // may be a part of a step: dealt with for itself, so that the others need not ask
  const int wholeEnd = end <= last ? end : last;
  int i = source.skip(begin);
  while (i < wholeEnd) {
    const int n = wholeEnd - i < Source::kBatch ? wholeEnd - i : Source::kBatch;
    for (uint32_t visible = source.classify(i, n); visible != 0; visible &= visible - 1) {
      const int k = lowestBit(visible);
      if (!pass(k, {i + k, lattice.tOfWholeStep(i + k), lattice.dt, source.alpha(k), source.color(k)})) return;
    }
    i = source.skip(i + n);
  }
  if (i < end && source.classifyLast()) {
    // From the opacity of a unit: that of a whole step may have become 1 in rounding, which tells nothing of a part of it.
    const float ds = lattice.stepLength(last);
    const float alpha = correctOpacity(source.unitAlpha(0), ds);
    pass(0, {last, lattice.t(last), ds, alpha, source.color(0) * (alpha / source.alpha(0))});
  }
}

}  // namespace warpscope
