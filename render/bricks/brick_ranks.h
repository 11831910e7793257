// A marcher whose volume is spread over ranks: the first of them asks, all march, each in its own brick.
// Rays go from brick to brick (ray_relay.h), so that a frame is the one that a single process makes.
#pragma once

#include "render/base/ranks.h"
#include "render/march/marcher.h"

namespace warpscope {

/// For the first rank. All others must be in followRanks() with the same volume, until the last marcher of this volume and those that came of it have gone. Their calls
/// wait for each other. Throws UsageError for more ranks than the volume can be cut for.
MarcherPtr makeRanksMarcher(VolumePtr volume, TransferFunction transferFunction);

/// For the others: does what the first one asks until that has no marcher of the volume any more. Throws std::runtime_error if what comes makes no sense.
void followRanks(const VolumePtr& volume);

}  // namespace warpscope
