// A marcher whose volume is spread over ranks: the first of them asks, all march, each in its own brick.
// Rays go from brick to brick (ray_relay.h), so that a frame is the one that a single process makes.
#pragma once

#include <memory>

#include "render/base/ranks.h"
#include "render/march/marcher.h"

namespace warpscope {

/// The first rank's side of a volume.
class BrickLeader;
using BrickLeaderPtr = std::shared_ptr<BrickLeader>;

/// For the first rank: others are in followRanks() with the same volume as long as this and what is made with it live. One for a volume.
BrickLeaderPtr leadRanks(VolumePtr volume);

/// Calls of it and of all others of the same leader wait for each other. Marching throws UsageError for more ranks than the volume can be cut for.
MarcherPtr makeRanksMarcher(BrickLeaderPtr leader, TransferFunction transferFunction);

/// For the others: does what the first one asks until its leader has gone. Throws std::runtime_error if what comes makes no sense.
/// Returns false where `stop` was set and the first one had not ended within a second.
bool followRanks(const VolumePtr& volume, const std::stop_token& stop = {});

}  // namespace warpscope
