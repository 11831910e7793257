// How much of a volume is kept in memory at a time, where that is limited.
#pragma once

#include "render/base/memory_limit.h"
#include "render/volume/volume.h"

namespace warpscope {

/// All of its slices, but of a mapped file that is too large for the limit. Who shares a volume with others marches a piece of it as it is.
inline uint32_t slicesKept(const Volume& volume) {
  const uint32_t slices = volume.dims().z;
  return isDroppable(volume.voxels()) && !volume.ranks() ? slicesAtATime(volume.sizeBytes() / slices, slices) : slices;
}

}  // namespace warpscope
