// Loops over ranges on all cores, by oneTBB. The one place that says how work is cut.
// Whoever works with a Crew has its loops run on that one's threads instead; see crew.h.
// Cancelling: a stop token is looked at before every piece; see OperationCancelled.
#pragma once

#include <cstddef>
#include <cstdint>
#include <stop_token>

#include "render/base/function_ref.h"

namespace warpscope {

class TurnsOfJob;

using RangeBody = FunctionRef<void(size_t begin, size_t end)>;
using TileBody = FunctionRef<void(uint32_t x0, uint32_t y0, uint32_t x1, uint32_t y1)>;

/// Calls body(begin, end) on pieces of [0, count) of about `grain` items, in parallel.
void parallelForRanges(size_t count, size_t grain, RangeBody body);

/// The same, with a look at `stop` before each piece, none longer than `grain`. Throws OperationCancelled if it is set.
void parallelForRanges(size_t count, size_t grain, const std::stop_token& stop, RangeBody body);

/// Calls body(i) for every i below `count`, in parallel, in turns with other jobs. Throws as TurnsOfJob::work does.
void parallelForInTurns(size_t count, TurnsOfJob& turns, const std::stop_token& stop, FunctionRef<void(size_t)> body);

/// Calls body(x0, y0, x1, y1) for tiles of at most `side` pixels that cover width x height, in turns where there are any. Throws
/// OperationCancelled if `stop` is set, and as TurnsOfJob::work does.
void parallelForTiles(uint32_t width, uint32_t height, uint32_t side, const std::stop_token& stop, TurnsOfJob& turns, TileBody body);
void parallelForTiles(uint32_t width, uint32_t height, uint32_t side, const std::stop_token& stop, TileBody body);

}  // namespace warpscope
