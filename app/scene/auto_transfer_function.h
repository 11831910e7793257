// A transfer function for a volume that brings none, from its histogram.
// Background is told from object by Otsu 1979; colours follow the object's quantiles.
#pragma once

#include "render/core/transfer_function.h"
#include "render/volume/volume.h"

namespace warpscope {

/// Never empty. What lies below Otsu's threshold is transparent; above it opacity and lightness rise with the value's rank, from blue-grey to
/// ivory.
TransferFunction autoTransferFunction(const VoxelStatistics& statistics);

}  // namespace warpscope
