// A volume of which a device has no room for all: slabs of it, one after the other, near to far, and all rays through each before the next one comes (cf. Cox, Ellsworth 1997,
// "Application-controlled demand paging for out-of-core visualization": what is read is what the picture needs).
#pragma once

#include <cstdint>
#include <limits>

#include "render/march/march_setup.h"
#include "render/march/marcher.h"
#include "render/march/ray_relay.h"

namespace warpscope {

/// What there is room for at once.
struct StreamRoom {
  int slices = 0;  ///< voxels along z; fewer than a slab of one cell takes are taken for as many
  uint64_t rayBytes = std::numeric_limits<uint64_t>::max();  ///< for what rays under way have gathered: of large pictures some rows of tiles after the other
  /// Nothing may have all of the volume. Else what needs that is marched whole, on the CPU: other modes than compositing, pre-integration, shadows and occlusion, the textbooks'
  /// arithmetic. So that shadows and occlusion are found in a coarse copy (PieceMarcher::setLightCopy()), and that arithmetic is refused.
  bool isForAll = false;
};

/// Frames and pictures are those of a marcher that has all of the volume, bit for bit.
MarcherPtr makeStreamedMarcher(MarchedVolumePtr marched, PieceMaker makePieces, const StreamRoom& room, TurnsPtr turns = nullptr);

/// A CPU's marcher: of a volume that the limit of memory has no room for (kept_slices.h), one that keeps to slabs of it. Arguments as makeCpuMarcher()'s.
MarcherPtr makeFittingCpuMarcher(VolumePtr volume, TransferFunction transferFunction);

}  // namespace warpscope
