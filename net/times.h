// Times as this room tells them: by the clock that its thread was handed.
#pragma once

#include "render/base/clock.h"

namespace warpscope::net {

using TimePoint = Clock::TimePoint;
using Duration = Clock::Duration;

}  // namespace warpscope::net
