// First hit of primary rays with one sphere per sample, the sample's colour, no shading: of several samples of a ray the nearest hides the others. Where the frame says how uncertain
// depths are (kSpreadPlane), spheres are drawn out along the rays that they were found on: capsules, as Zellmann 2020 proposes in section 6.
// Zellmann 2020, over a linear BVH (Karras 2012) or, as a check and baseline, Embree.
#pragma once

#include <array>

#include "render/warp/warp.h"

namespace warpscope {

/// How the first sphere along each pixel's ray is found. All find the same.
enum class SphereTracing {
  automatic,   ///< footprints, or lbvh on the CPU and clusters on a CUDA device: what suits the view (sphere_ways.h). lbvh where only that knows what is asked for
  lbvh,        ///< the binary hierarchy of Karras 2012
  clusters,    ///< the hierarchy as wide as a warp, on CUDA devices only
  embree,      ///< on the CPU only
  footprints,  ///< no hierarchy: what `splats` does
};

inline constexpr std::array<NamedValue<SphereTracing>, 5> kSphereTracings{{
    {SphereTracing::automatic, "auto", "footprints, or lbvh on the CPU and clusters on a CUDA device: whichever is faster for the view"},
    {SphereTracing::lbvh, "lbvh", "the binary hierarchy of Karras 2012"},
    {SphereTracing::clusters, "clusters", "a hierarchy of boxes around 32 neighbours each, as wide as a warp; CUDA only"},
    {SphereTracing::embree, "embree", "Embree's hierarchy; CPU only"},
    {SphereTracing::footprints, "footprints", "no hierarchy: each sphere is met by the rays of the pixels that it may cover, as splats does"},
}};

/// A SphereTracing.
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
