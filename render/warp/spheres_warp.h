// First hit of primary rays with one sphere per sample, the sample's colour, no shading: of several samples of a ray the nearest hides the others. Where the frame says how uncertain
// depths are (kSpreadPlane), spheres are drawn out along the rays that they were found on: capsules, as Zellmann 2020 proposes in section 6.
// Zellmann 2020, over a linear BVH (Karras 2012) or, as a check and baseline, Embree.
#pragma once

#include <array>

#include "render/warp/warp.h"

namespace warpscope {

enum class SphereTracing {
  automatic,  ///< what is fastest where the technique runs: lbvh on the CPU, clusters on a CUDA device
  lbvh,       ///< the binary hierarchy of Karras 2012
  clusters,   ///< the hierarchy as wide as a warp, on CUDA devices only
  embree,     ///< on the CPU only
};

inline constexpr std::array<NamedValue<SphereTracing>, 4> kSphereTracings{{
    {SphereTracing::automatic, "auto", "what is fastest: lbvh on the CPU, clusters on a CUDA device"},
    {SphereTracing::lbvh, "lbvh", "the binary hierarchy of Karras 2012"},
    {SphereTracing::clusters, "clusters", "boxes of 32 neighbours each, as wide as a warp; CUDA only"},
    {SphereTracing::embree, "embree", "Embree's; CPU only"},
}};

/// The hierarchy: a SphereTracing.
extern const Knob kSphereTracingKnob;

/// How far spheres are drawn out, in spreads to both sides of their depth; 0: not at all.
extern const Knob kSmearKnob;

/// The frame's plane kSpreadPlane, a float for each sample; null if it has none.
const SamplePlane* spreadsOf(const SampleFrame& frame);

/// Throws UsageError where the settings ask for a hierarchy that does not know the arithmetic that they ask for.
void requireTraceable(const WarpSettings& settings);
/// Likewise that know no capsules.
void requireCapsules(const WarpSettings& settings);

extern const WarpDescriptor kSpheresWarp;

}  // namespace warpscope
