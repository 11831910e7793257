// Where the samples and segments of a frame lie along the rays of their pixels, as a look at some of them says: what coders begin with.
#pragma once

#include "render/march/pixel_places.h"
#include "render/march/sample_frame.h"

namespace warpscope {

/// Whether the rays of a frame's pixels have a lattice: else there is Placement::depth alone.
bool hasLattice(const SampleFrame& frame);

/// What the rays of a frame share, with the host's noise.
PathGrid pathGridOf(const SampleFrame& frame, Placement placement);

/// Steps or half steps, if a look at some of the frame's samples says that they lie on them.
Placement placementOf(const SampleFrame& frame);
/// kBorders, if a look at some of the frame's segments says that they begin there; else depth.
Placement borderPlacementOf(const SampleFrame& frame);

/// Of samples, and of pixels' rays, about so many are looked at: at equal strides, from the first on.
inline constexpr size_t kFrameProbes = 256;
WARPSCOPE_HD inline size_t probeStride(size_t count) { return count < 2 * kFrameProbes ? 1 : count / kFrameProbes; }
/// There are never more.
inline constexpr size_t kMostFrameProbes = 2 * kFrameProbes;

/// What was seen of samples.
struct SampleVotes {
  uint32_t looked = 0, onSteps = 0, onHalfSteps = 0;

  Placement placement() const {
    return onSteps * 8 >= looked * 7 ? Placement::steps : onHalfSteps * 8 >= looked * 7 ? Placement::halfSteps : Placement::depth;
  }
};

/// What was seen of rays that have segments.
struct BorderVotes {
  uint32_t looked = 0, nearBorders = 0;

  Placement placement() const { return nearBorders * 8 >= looked * 7 ? kBorders : Placement::depth; }
};

/// `step`, `depthStep`: of the frame (PathGrid). `isHalf`: on half steps, else on steps.
WARPSCOPE_HD inline bool isOnLattice(const PixelPath& path, uint32_t depthCode, float step, float depthStep, bool isHalf) {
  const int32_t place = placeOnPath(path, depthCode, step, depthStep, isHalf);
  return depthCodeOnPath(path, place, step, depthStep, isHalf ? Placement::halfSteps : Placement::steps) == depthCode;
}
/// A code beside it is rounding.
WARPSCOPE_HD inline bool isNearBorder(const PixelPath& path, uint32_t depthCode, float step, float depthStep) {
  return depthCode + 1 - depthCodeOnPath(path, borderOnPath(path, depthCode, step, depthStep), step, depthStep, kBorders) <= 2;
}

}  // namespace warpscope
