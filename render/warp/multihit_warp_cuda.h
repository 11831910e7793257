// `multihit` on a CUDA device.
// See multihit_warp.h; hierarchy: clusters/cluster_tree.h.
#pragma once

#include "render/warp/warp.h"

namespace warpscope {

/// Throws DeviceError if there is no device or no CUDA in this build.
std::unique_ptr<Warp> makeCudaMultihitWarp();

}  // namespace warpscope
