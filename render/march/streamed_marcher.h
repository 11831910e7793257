// A volume of which a device has no room for all: slabs of it, one after the other, near to far, and all rays through each before the next one comes (cf. Cox, Ellsworth 1997,
// "Application-controlled demand paging for out-of-core visualization": what is read is what the picture needs).
#pragma once

#include "render/march/march_setup.h"
#include "render/march/marcher.h"
#include "render/march/ray_relay.h"

namespace warpscope {

/// Frames and pictures are those of a marcher that has all of the volume, bit for bit. `slices`: voxels along z that there is room for at once;
/// fewer than a slab of one cell takes are taken for as many.
/// What needs all of the volume at once is marched on the CPU: other modes than compositing, pre-integration, shadows and occlusion, the textbooks' arithmetic.
MarcherPtr makeStreamedMarcher(MarchedVolumePtr marched, PieceMaker makePieces, int slices, TurnsPtr turns = nullptr);

}  // namespace warpscope
