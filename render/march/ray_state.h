// Light, opacity and the heuristic's fold of a ray or a piece of one, so that pieces can be put together. Host and device.
// Front to back by Porter, Duff 1984 ("over", associative); pieces may be other machines' (cf. Hsu 1993).
//
// How pieces of one ray are marched: a piece's light is its own, as if nothing lay in front of it, but which samples
// count is decided by what reaches the eye. So the transmittance in front of a piece comes first (a march by RayOpacity
// gives each piece's; their product is what lies in front), then marchPiece(), and for two-pass heuristics, once the
// pieces' profiles are combined, marchPieceAgain().
#pragma once

#include <type_traits>

#include "render/march/march.h"

namespace warpscope {

/// Transmittance of a piece: with all that lies in front of it, and alone.
class PieceTransmittance {
 public:
  WARPSCOPE_HD explicit PieceTransmittance(Transmittance inFront = Transmittance()) : whole_(inFront) {}

  /// From the eye on: what counts, and where the ray ends, is decided by it.
  WARPSCOPE_HD float value() const { return whole_.value(); }
  WARPSCOPE_HD double exact() const { return whole_.exact(); }
  WARPSCOPE_HD const Transmittance& alone() const { return alone_; }
  WARPSCOPE_HD void pass(float alpha) {
    whole_.pass(alpha);
    alone_.pass(alpha);
  }
  /// What follows is another piece.
  WARPSCOPE_HD void restart() { alone_ = Transmittance(); }

 private:
  Transmittance whole_;
  Transmittance alone_;
};

/// What marchRay gathers of a piece.
class RayPiece {
 public:
  using March = StableMarch;
  static constexpr bool kWantsColor = true;

  WARPSCOPE_HD explicit RayPiece(Transmittance inFront = Transmittance()) : transmittance(inFront) {}

  WARPSCOPE_HD void add(const ClassifiedSample& sample, const glm::vec3& color, float) { light_.add(sample.i, color, transmittance.alone().value()); }
  /// Linear, premultiplied, as if nothing lay in front.
  WARPSCOPE_HD glm::dvec3 color() const { return light_.color(); }
  WARPSCOPE_HD glm::vec4 premultiplied() const { return {glm::vec3(color()), transmittance.alone().opacity()}; }
  /// What follows is another piece.
  WARPSCOPE_HD void restart() {
    light_ = LightSum();
    transmittance.restart();
  }

  PieceTransmittance transmittance;

 private:
  LightSum light_;
};

/// As RayPiece, for a pass that wants depths only.
struct PieceOpacity {
  using March = StableMarch;
  static constexpr bool kWantsColor = false;

  PieceTransmittance transmittance;

  WARPSCOPE_HD void add(const ClassifiedSample&, const glm::vec3&, float) {}
  WARPSCOPE_HD void restart() { transmittance.restart(); }
};

/// What a piece sends towards the eye and lets through. Default: nothing, and all.
struct RayLight {
  glm::dvec3 color{0.0};  ///< linear, premultiplied, as if nothing lay in front
  double transmittance = 1.0;

  /// The back's light is seen through the front.
  WARPSCOPE_HD static RayLight combine(const RayLight& front, const RayLight& back) {
    return {front.color + front.transmittance * back.color, front.transmittance * back.transmittance};
  }
  WARPSCOPE_HD glm::vec4 premultiplied() const { return {glm::vec3(color), static_cast<float>(1.0 - transmittance)}; }
};

/// All of a ray's state by the heuristic `Depth` (depth_heuristic.h). Default: the identity of combine(), which is
/// associative up to rounding. Plain data without pointers: on a wire its members follow one another in this order,
/// those of `light` as doubles, the folds' as floats and flags. What every piece of a ray is told alike (the heuristic,
/// its parameter) is in each.
template <class Depth>
struct RayState {
  RayLight light;
  ProfileFold profile;          ///< of a first pass, where the heuristic has two
  typename Depth::Fold fold{};  ///< of the only or the second pass

  WARPSCOPE_HD static RayState combine(const RayState& front, const RayState& back) {
    return {RayLight::combine(front.light, back.light), ProfileFold::combine(front.profile, back.profile),
            Depth::Fold::combine(front.fold, back.fold)};
  }
  WARPSCOPE_HD DepthResult depth() const { return Depth::result(fold); }
};

/// Marches samples [begin, end) of the path, behind `inFront`: their light, and the only pass of the heuristic or the
/// first of two. The other parameters are marchRay's; `threshold` is the heuristic's.
template <class Depth, class Source, class Light>
WARPSCOPE_HD inline RayState<Depth> marchPiece(const RayPath& path, int begin, int end, Source& source,
                                               const Light& light, const RayLimits& limits, float threshold,
                                               const Transmittance& inFront) {
  RayState<Depth> state;
  if (inFront.value() < limits.stopBelow) return state;  // the ray ended before
  if constexpr (!Depth::kTwoPass) state.fold = Depth::start(threshold, state.profile);
  RayPiece piece(inFront);
  marchRay(path, begin, end, source, light, limits, piece, [&](const CountingSample& sample) {
    if constexpr (Depth::kTwoPass)
      state.profile.add(sample);
    else
      state.fold.add(sample);
    return true;
  });
  state.light = {piece.color(), piece.transmittance.alone().exact()};
  return state;
}

/// The second pass of a two-pass heuristic over the same samples: the fold alone. `profile` is the whole ray's.
template <class Depth, class Source, class Light>
WARPSCOPE_HD inline typename Depth::Fold marchPieceAgain(const RayPath& path, int begin, int end, Source& source,
                                                         const Light& light, const RayLimits& limits, float threshold,
                                                         const Transmittance& inFront, const ProfileFold& profile) {
  static_assert(Depth::kTwoPass);
  auto fold = Depth::start(threshold, profile);
  if (inFront.value() < limits.stopBelow) return fold;
  RayOpacity opacity{inFront};
  marchRay(path, begin, end, source, light, limits, opacity, [&](const CountingSample& sample) {
    fold.add(sample);
    return !fold.crossed;
  });
  return fold;
}

}  // namespace warpscope
