// Which points of one view another view saw: what a warp could know, and what was hidden from it.
// The usual test of shadow and reprojection methods: project the point into the other view, compare with what that view found there.
#pragma once

#include "render/core/image.h"
#include "render/march/sample_frame.h"

namespace warpscope {

/// What the frame could know of a pixel of another view.
enum class Visibility : uint8_t {
  empty,        ///< no sample: nothing to see
  visible,      ///< the frame has a sample of that place
  disoccluded,  ///< it has none: the place was hidden, or outside its image
};

/// For each pixel of `reference`, which has the size of that frame's camera: had `frame` a sample of what is there? `frame` is what the server
/// sent, `reference` was marched with the same heuristic for the camera of now. Images of both may differ in size.
///
/// A point of `reference` is visible if it projects into the image of `frame` and one of the samples of the 3x3 pixels around is nearer to it than
///   a voxel's diagonal + the diagonal of a pixel of `frame` at the point's distance + a step of both frames' quantisation.
/// The first is how far two rays' depths of one place may lie apart, as heuristics find them; the second how far apart the frame's rays are, with
/// as much again along the ray, for surfaces that are seen at 45 degrees: a place that the frame saw at a flatter angle than its pixels and the
/// voxels resolve counts as disoccluded. The resolution of `reference` does not matter: its points are points. Where a pixel has several samples,
/// that of `reference` nearest to the eye counts, and all of `frame`.
///
/// Throws InputError if a camera is not usable.
Image<Visibility> visibilityOf(const SampleFrame& frame, const SampleFrame& reference);

}  // namespace warpscope
