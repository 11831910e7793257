// The copy of the volume on a CUDA device, a ray a thread.
// The march is that of the CPU, with the same bits.
#pragma once

#include <memory>

#include "render/warp/warp.h"

namespace warpscope {

/// Throws DeviceError if no device can be used.
std::unique_ptr<Warp> makeCudaProxyWarp();

}  // namespace warpscope
