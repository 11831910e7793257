// Tiles of frames made by a CUDA device. The bytes are those of the host, and each reads the other's.
#pragma once

#include "render/codec/tiled/tiled_coder.h"

namespace warpscope {

/// Throws DeviceError, as do the coder's calls.
TiledCoderPtr makeCudaTiledCoder();

}  // namespace warpscope
