// `spheres` on a CUDA device.
// See spheres_warp.h; hierarchies: clusters/cluster_tree.h and lbvh/device_lbvh.h.
#pragma once

#include "render/warp/warp.h"

namespace warpscope {

/// Throws DeviceError if there is no device or no CUDA in this build.
std::unique_ptr<Warp> makeCudaSpheresWarp();

}  // namespace warpscope
