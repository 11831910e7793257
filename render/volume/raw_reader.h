// Raw volumes: a file that holds nothing but voxels, described by its name. It is mapped, never read or copied.
// Open SciVis Datasets (Klacansky): `name_XxYxZ_type.raw`, x fastest, little endian.
#pragma once

#include <filesystem>
#include <optional>

#include "render/volume/reader.h"

namespace warpscope {

/// Maps `path`, an existing and not empty regular file. Throws InputError if its name is not that of a raw volume or
/// its size is not what the name says; OperationCancelled if `stop` is set. `ranks`: see Volume; each has the file.
VolumePtr openRawVolume(const std::filesystem::path& path, const std::optional<glm::dvec3>& spacing, const std::stop_token& stop, RanksPtr ranks = nullptr);

}  // namespace warpscope
