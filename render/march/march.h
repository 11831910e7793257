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
struct RayColor {
  glm::dvec3 color{0.0};  ///< linear, premultiplied; double for the same reason as transmittance
  Transmittance transmittance;

  WARPSCOPE_HD void add(const glm::vec3& contribution) { color += glm::dvec3(contribution); }
  WARPSCOPE_HD glm::vec4 premultiplied() const { return {glm::vec3(color), transmittance.opacity()}; }
};

/// As RayColor, for a pass that wants depths only.
struct RayOpacity {
  Transmittance transmittance;

  WARPSCOPE_HD void add(const glm::vec3&) {}
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
///   uint32_t classify(int i, int n)   looks at samples i .. i + n - 1, n <= kBatch <= 32; bit k is set if the k-th has any opacity
///   float alpha(int k)             opacity of the k-th of them, corrected to the lattice's dt
///   glm::vec3 color(int k)         its colour times that opacity
/// `sink` is called with a CountingSample for every sample whose contribution is at least `contribution`, near to far; if it returns
/// false, the ray ends there, before that sample's light is added.
/// Ends where transmittance falls below `stopBelow` (0: never): what follows cannot count any more, as long as stopBelow <= contribution.
template <class Source, class Gathered, class Sink>
WARPSCOPE_HD inline void marchRay(const RayLattice& lattice, int begin, int end, Source& source, float contribution,
                                  float stopBelow, Gathered& ray, Sink&& sink) {
  for (int i = source.skip(begin); i < end; i = source.skip(i)) {
    const int n = end - i < Source::kBatch ? end - i : Source::kBatch;
    for (uint32_t visible = source.classify(i, n); visible != 0; visible &= visible - 1) {
      const int k = lowestBit(visible);
      float alpha = source.alpha(k);
      glm::vec3 color = source.color(k);
      float ds = lattice.dt;
      if (i + k + 1 == lattice.count) {  // the last step may be a part of one
        ds = lattice.stepLength(i + k);
        const float whole = alpha;
        alpha = correctOpacity(whole, ds / lattice.dt);
        color *= alpha / whole;
      }
      const float before = ray.transmittance.value();
      if (before * alpha >= contribution && !sink(CountingSample{lattice.t(i + k), ds, alpha, before})) return;
      ray.add(before * color);
      ray.transmittance.pass(alpha);
      if (ray.transmittance.value() < stopBelow) return;
    }
    i += n;
  }
}

}  // namespace warpscope
