// A technique whose gaps are filled: from frames that came before, and by what the knob `fill` says. On the host.
// The same for all techniques: kept_frames.h, proxy_fill.h, pull_push.h.
#pragma once

#include <functional>
#include <memory>

#include "render/warp/warp.h"

namespace warpscope {

/// Draws with what `make` makes, once for each frame that is kept. A picture that needs nothing beside is the technique's own, left where it was drawn.
std::unique_ptr<Warp> makeCompletedWarp(const WarpDescriptor& technique, std::function<std::unique_ptr<Warp>()> make);

}  // namespace warpscope
