// Volumes in the formats that ITK reads: NRRD, NIfTI, MetaImage, VTK legacy, GIPL, MRC.
// The one place that knows ITK (Insight Toolkit 5); nothing of it shows here. Built only with WARPSCOPE_WITH_ITK.
#pragma once

#include <filesystem>

#include "render/volume/volume.h"

namespace warpscope {

/// Reads `path`, an existing and not empty regular file, in its stored voxel type. Scalar 3D volumes only (2D images
/// become one slice); vectors, colours, complex numbers, several time points and 64-bit integers are refused. World
/// axes are ITK's: left, posterior, superior. Negative spacing turns its axis round; zero spacing is accepted for an
/// axis of one voxel only. Throws InputError that says what is wrong; OperationCancelled if `stop` is set, which ITK
/// itself does not look at. What is too large for the limit of memory is read by rows, as shared volumes are, where it can be.
VolumePtr openItkVolume(const std::filesystem::path& path, const std::stop_token& stop);

/// The same volume for ranks that share it: each reads what it is asked for. Files whose voxels lie there as they are, in one piece and not compressed: NIfTI, NRRD,
/// MetaImage. Throws InputError for others.
VolumePtr openSharedItkVolume(const std::filesystem::path& path, const std::stop_token& stop, RanksPtr ranks);

}  // namespace warpscope
