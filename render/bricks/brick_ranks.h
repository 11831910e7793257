// A marcher whose volume is spread over ranks: the first of them asks, all march, each in its own brick.
// Rays go from brick to brick (ray_relay.h), so that a frame is the one that a single process makes.
#pragma once

#include <chrono>
#include <memory>
#include <vector>

#include "render/base/ranks.h"
#include "render/bricks/brick_frame.h"
#include "render/march/marcher.h"
#include "render/march/ray_relay.h"

namespace warpscope {

/// The first rank's side of a volume.
class BrickLeader;
using BrickLeaderPtr = std::shared_ptr<BrickLeader>;

/// A rank that says nothing for so long while a frame is marched is taken for one that never will.
inline constexpr std::chrono::seconds kRankPatience(10);

/// For the first rank: others are in followRanks() with the same volume as long as this and what is made with it live. One for a volume.
/// `makePieces`: what this rank marches its brick by; others may march theirs otherwise.
BrickLeaderPtr leadRanks(VolumePtr volume, std::chrono::milliseconds patience = kRankPatience, PieceMaker makePieces = {});

/// What each rank has done for the last frame, by rank; what has not come within a second is of another frame.
std::vector<RankWork> lastWork(const BrickLeaderPtr& leader);

/// The same of what has come by now: waits for nobody, not for a frame either.
std::vector<RankWork> knownWork(const BrickLeaderPtr& leader);

/// Calls of it and of all others of the same leader wait for each other. Marching throws UsageError for more ranks than the volume can be cut for, InputError where one of
/// them cannot march or does not answer.
MarcherPtr makeRanksMarcher(BrickLeaderPtr leader, TransferFunction transferFunction);

/// For the others: does what the first one asks until its leader has gone. Throws std::runtime_error if what comes makes no sense.
/// Returns false where `stop` was set and the first one had not ended soon after.
bool followRanks(const VolumePtr& volume, const std::stop_token& stop = {}, PieceMaker makePieces = {});

}  // namespace warpscope
