// Rays through segments, one a thread, on a CUDA device.
// The walk is that of the CPU, with the same bits.
#pragma once

#include <memory>

#include "render/warp/warp.h"

namespace warpscope {

/// Throws DeviceError if no device can be used.
std::unique_ptr<Warp> makeCudaSegmentsWarp();

}  // namespace warpscope
