// A server whose processor others use too, simulated: what it does for a frame takes as long as it would get its share of the time.
// Processor sharing (Kleinrock 1967): with a share 1 - L of the processor, work of t takes t / (1 - L). Nobody computes meanwhile, so that a display on the
// same machine is not slowed down.
#pragma once

#include <initializer_list>
#include <stop_token>

#include "render/base/clock.h"

namespace warpscope {

/// Waits for what these stages would have taken longer, and makes them so long. `loadPercent`: of the processor that others take, 0 to less than 100.
/// Throws OperationCancelled if `stop` is set.
void shareProcessor(std::initializer_list<double*> stagesMs, int loadPercent, Clock& clock, const std::stop_token& stop);

}  // namespace warpscope
