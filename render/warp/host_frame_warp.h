// A technique that draws from host memory, given frames that may be on a device alone.
#pragma once

#include <memory>

#include "render/warp/warp.h"

namespace warpscope {

/// Brings each frame to host memory (onHost()) where it is away, before `warp` takes it; a device that lost it is a DeviceError then.
std::unique_ptr<Warp> makeHostFrameWarp(std::unique_ptr<Warp> warp);

}  // namespace warpscope
