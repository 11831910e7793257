// A volume without what a mask hides: segmented bones without the table they lie on. Host only.
// What is hidden becomes not finite, so that it has no weight in interpolation (voxel_access.h): nothing of it bleeds into what is kept.
#pragma once

#include <stop_token>

#include "render/volume/volume.h"

namespace warpscope {

/// The voxels of `volume` where the mask's are neither 0 nor NaN; elsewhere NaN. Of single precision where that holds the type's values exactly, else
/// of double precision; takes that much memory beside the two. The mask's own geometry does not matter as long as it has as many voxels along each
/// axis and, where both state one, the same place and directions to within a tenth of a voxel.
/// Throws InputError, with both names, where it has not, where it hides everything or where memory is short; OperationCancelled if `stop` is set.
VolumePtr masked(const Volume& volume, const Volume& mask, const std::stop_token& stop = {});

}  // namespace warpscope
