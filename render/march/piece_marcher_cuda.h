// Pieces of rays on a CUDA device: see PieceMarcher (ray_relay.h).
#pragma once

#include <functional>
#include <string>

#include "render/march/marcher.h"
#include "render/march/ray_relay.h"

namespace warpscope {

/// Marchers on the first CUDA device that this process sees, which holds the relay's block and no other voxels, once for all that this makes; the same bits as on the CPU. Tiles go to the
/// CPU of whose rays more samples have to be listed than there is room for: all that count, of several samples a ray and heuristics of two passes. What arrives of the lights the
/// CPU finds out as well. All tiles do once the device has failed, of which `onFallback` (may be empty) is told the reason, once, on whatever thread met it; without `mayFallBack`
/// marchPieces() throws DeviceError instead. Throws DeviceError, as what it returns does.
PieceMaker makeCudaPieces(bool mayFallBack, std::function<void(const std::string& reason)> onFallback);

/// makeCudaMarcher() of a volume that the device has room for, or may have (setDeviceMemoryLimit()); of another one slabs go to the device one after the other.
MarcherPtr makeFittingCudaMarcher(VolumePtr volume, TransferFunction transferFunction);

}  // namespace warpscope
