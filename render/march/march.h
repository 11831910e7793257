// One ray through a volume, front to back: the loop that the CPU and the GPU share. Where the values come from is the source's business.
// Emission and absorption, front-to-back compositing with early termination (Levoy 1990; Max 1995).
#pragma once

#include <bit>
#include <cstdint>

#include "render/core/transfer_function.h"
#include "render/march/depth_heuristic.h"
#include "render/march/lattice.h"
#include "render/march/transmittance.h"

namespace warpscope {

/// What a ray has gathered so far; carried from one segment of a ray to the next.
/// Sums of sums: light is added up in float over a block of the lattice's samples, blocks in double, for the same reason as transmittance.
/// Blocks are those of the lattice, so that it does not matter in which pieces a ray is marched.
class RayColor {
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
  WARPSCOPE_HD glm::vec4 premultiplied() const { return {glm::vec3(color()), transmittance.opacity()}; }

  Transmittance transmittance;

 private:
  static constexpr int kBlockBits = 4;

  glm::dvec3 sum_{0.0};
  glm::vec3 ofBlock_{0.0f};
  int block_ = 0;
};

/// As RayColor, for a pass that wants depths only.
struct RayOpacity {
  Transmittance transmittance;

  WARPSCOPE_HD void add(int, const glm::vec3&, float) {}
};

/// Place of the lowest bit that is set; `bits` is not 0.
WARPSCOPE_HD inline int lowestBit(uint32_t bits) {
#if defined(__CUDA_ARCH__)
  return __ffs(static_cast<int>(bits)) - 1;
#else
  return std::countr_zero(bits);
#endif
}

/// Marches samples [begin, end) of `lattice`.
///
/// `Source` tells what the samples look like, up to Source::kBatch at a time:
///   int skip(int i)                first sample >= i that may be visible
///   uint32_t classify(int i, int n)   looks at samples i .. i + n - 1, n <= kBatch <= 32, none of them the lattice's last; bit k is set if
///                                  the k-th has any opacity
///   bool classifyLast()            looks at the lattice's last sample alone; true if it has any opacity
///   float alpha(int k)             opacity of the k-th that was looked at, corrected to the lattice's dt
///   glm::vec3 color(int k)         its colour times that opacity
/// `sink` is called with a CountingSample for every sample whose contribution is at least `contribution`, near to far; if it returns
/// false, the ray ends there, before that sample's light is added.
/// Ends where transmittance falls below `stopBelow` (0: never): what follows cannot count any more, as long as stopBelow <= contribution.
template <class Source, class Gathered, class Sink>
WARPSCOPE_HD inline void marchRay(const RayLattice& lattice, int begin, int end, Source& source, float contribution,
                                  float stopBelow, Gathered& ray, Sink&& sink) {
  float through = ray.transmittance.value();
  // False where the ray ends.
  const auto pass = [&](int i, float t, float ds, float alpha, const glm::vec3& color) {
    if (through * alpha >= contribution && !sink(CountingSample{t, ds, alpha, through})) return false;
    ray.add(i, color, through);
    ray.transmittance.pass(alpha);
    through = ray.transmittance.value();
    return !(through < stopBelow);
  };

  const int last = lattice.count - 1;  // may be a part of a step: dealt with for itself, so that the others need not ask
  const int wholeEnd = end <= last ? end : last;
  int i = source.skip(begin);
  while (i < wholeEnd) {
    const int n = wholeEnd - i < Source::kBatch ? wholeEnd - i : Source::kBatch;
    for (uint32_t visible = source.classify(i, n); visible != 0; visible &= visible - 1) {
      const int k = lowestBit(visible);
      if (!pass(i + k, lattice.tOfWholeStep(i + k), lattice.dt, source.alpha(k), source.color(k))) return;
    }
    i = source.skip(i + n);
  }
  if (i < end && source.classifyLast()) {
    const float ds = lattice.stepLength(last);
    const float whole = source.alpha(0);
    const float alpha = correctOpacity(whole, ds / lattice.dt);
    pass(last, lattice.t(last), ds, alpha, source.color(0) * (alpha / whole));
  }
}

}  // namespace warpscope
