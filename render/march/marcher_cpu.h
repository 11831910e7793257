// Marching on the CPU's cores, tiles of the image in parallel (oneTBB).
// Samples are classified in batches along the ray, which compilers turn into vector code; the loop itself is march.h's.
#pragma once

#include "render/march/marcher.h"

namespace warpscope {

struct MarchedVolume;

/// Never fails for a valid volume; keeps the volume alive.
MarcherPtr makeCpuMarcher(VolumePtr volume, TransferFunction transferFunction);
/// The same of what has been made of both already, in `turns` if there are any.
MarcherPtr makeCpuMarcherOf(std::shared_ptr<const MarchedVolume> marched, TurnsPtr turns);

}  // namespace warpscope
