// `splats` on a CUDA device.
// See splats_warp.h and splats/device_splats.h.
#pragma once

#include "render/warp/warp.h"

namespace warpscope {

/// Throws DeviceError if there is no device or no CUDA in this build.
std::unique_ptr<Warp> makeCudaSplatsWarp();

}  // namespace warpscope
