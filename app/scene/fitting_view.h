// From how far away a camera has in its picture all that a transfer function shows of a volume.
// The distance is that of scene.h: 1 is where the volume's bounding sphere fills the picture, and always far enough.
#pragma once

#include <stop_token>

#include "app/scene/scene.h"
#include "render/core/box.h"

namespace warpscope {

/// The box of the volume's cells in which the transfer function gives anything opacity, in volume space: up to a cell more than what is visible
/// (see macrocells.h), and empty where nothing is. Reads every voxel. Throws OperationCancelled if `stop` is set.
Box visibleBounds(const Volume& volume, const TransferFunction& function, const std::stop_token& stop = {});

/// The least distance, at most 1, from which a camera that stands as `view` says and looks at the volume's centre has the whole of `box` in its
/// picture, with a margin: in pictures as wide as high at the scene's field of view, and so in those that are wider, or narrower, or of a
/// narrower field of view. `box` is in volume space, inside the volume's bounds, and not empty.
double fittingDistance(const Scene& scene, const View& view, const Box& box);

/// defaultViews(), all nearer or farther by one factor: in the first, what is visible fits the picture.
std::vector<View> fittingViews(const Scene& scene, const std::stop_token& stop = {});

}  // namespace warpscope
