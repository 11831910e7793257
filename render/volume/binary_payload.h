// Where files whose headers are bytes keep their voxels: NIfTI and MRC.
// NIfTI-1 and -2 (Cox et al. 2004), MRC2014 (Cheng et al. 2015): in either byte order, limited as payload.h says.
#pragma once

#include "render/volume/payload.h"

namespace warpscope {

// Both throw InputError, as locatePayload().
Payload locateNifti(const std::filesystem::path& path);
Payload locateMrc(const std::filesystem::path& path);

}  // namespace warpscope
