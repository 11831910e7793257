// Voxels that are much longer than wide, for which a radius that is the same for all samples is wrong one way or the other.
// What the policies make of a voxel: render/march/sample_radius.h.
#pragma once

#include <optional>
#include <string>

#include "render/march/march_settings.h"
#include "render/volume/volume.h"

namespace warpscope {

/// From this ratio of the longest to the shortest voxel edge on, people are told.
inline constexpr double kLongVoxelRatio = 2.0;

/// What is wrong with the radius for voxels of that shape, and what to choose instead; nothing where it fits.
std::optional<std::string> radiusWarning(const VolumeGeometry& geometry, RadiusPolicy policy);

}  // namespace warpscope
