// What a march does with its numbers, in the two forms of core/arithmetic.h: policies known at compile time.
// Textbook forms: Engel et al. 2006, sections 3.2 and 9.1 (compositing, opacity correction), as they are printed.
#pragma once

#include <cmath>

#include "render/core/arithmetic.h"
#include "render/core/transfer_function.h"
#include "render/march/lattice.h"
#include "render/march/light_sum.h"
#include "render/march/transmittance.h"

namespace warpscope {

/// Places by index, transmittance in double, light in sums of sums, opacity of parts of a step from that of a unit.
struct StableMarch {
  static constexpr bool kPlacesByIndex = true;
  static constexpr bool kLeavesOutMissing = true;  ///< voxels that are not finite; else what is blended with them is not either
  using Transmittance = warpscope::Transmittance;
  using LightSum = warpscope::LightSum;

  /// What a source that goes along a ray keeps: nothing.
  class Places {
   public:
    WARPSCOPE_HD explicit Places(const RayLattice&) {}
    WARPSCOPE_HD float next(const RayLattice& lattice, int i) { return lattice.tOfWholeStep(i); }
  };

  /// Opacity of the last sample that `source` looked at, over `ds` instead of a whole step. From the opacity of a unit: that
  /// of a whole step may have become 1 in rounding, which tells nothing of a part of it.
  template <class Source>
  WARPSCOPE_HD static float partOfStep(const Source& source, float ds, float /*dt*/) {
    return correctOpacity(source.unitAlpha(0), ds);
  }
};

/// Opacity that adds up in single precision. The interface is Transmittance's.
class AccumulatedOpacity {
 public:
  WARPSCOPE_HD float value() const { return 1.0f - accumulated_; }
  WARPSCOPE_HD double exact() const { return static_cast<double>(value()); }
  WARPSCOPE_HD float opacity() const { return accumulated_; }
  WARPSCOPE_HD void pass(float alpha) { accumulated_ += (1.0f - accumulated_) * alpha; }

 private:
  float accumulated_ = 0.0f;
};

/// One sum in single precision. The interface is LightSum's.
class PlainLightSum {
 public:
  WARPSCOPE_HD void add(int, const glm::vec3& color, float through) { sum_ += through * color; }
  WARPSCOPE_HD glm::vec3 color() const { return sum_; }

 private:
  glm::vec3 sum_{0.0f};
};

/// As textbooks print it.
struct TextbookMarch {
  static constexpr bool kPlacesByIndex = false;
  static constexpr bool kLeavesOutMissing = false;
  using Transmittance = AccumulatedOpacity;
  using LightSum = PlainLightSum;

  /// t += dt from sample to sample; what is leapt over is added at once.
  class Places {
   public:
    WARPSCOPE_HD explicit Places(const RayLattice& lattice) : t_(lattice.t0 + 0.5f * lattice.dt) {}
    WARPSCOPE_HD float next(const RayLattice& lattice, int i) {
      t_ += static_cast<float>(i - i_) * lattice.dt;
      i_ = i;
      return t_;
    }

   private:
    float t_;
    int i_ = 0;
  };

  template <class Source>
  WARPSCOPE_HD static float partOfStep(const Source& source, float ds, float dt) {
    return 1.0f - std::pow(1.0f - source.alpha(0), ds / dt);
  }
};

/// Calls `f` with the policy.
template <class F>
decltype(auto) visitMarchArithmetic(Arithmetic arithmetic, F&& f) {
  if (arithmetic == Arithmetic::textbook) return f(TextbookMarch{});
  return f(StableMarch{});
}

}  // namespace warpscope
