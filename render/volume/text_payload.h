// Where files whose headers are text keep their voxels: NRRD, MetaImage, VTK legacy.
// NRRD (Kindlmann), MetaImage (Kitware): lines of "key separator value", limited as payload.h says.
#pragma once

#include "render/volume/payload.h"

namespace warpscope {

// All throw InputError, as locatePayload().
Payload locateNrrd(const std::filesystem::path& path);
Payload locateMetaImage(const std::filesystem::path& path);
Payload locateVtk(const std::filesystem::path& path);

}  // namespace warpscope
