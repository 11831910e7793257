// A technique that leaves a device which fails it, and goes on elsewhere with the frame that it had.
// See march/fallback_marcher.h for the server's side.
#pragma once

#include "render/warp/warp.h"

namespace warpscope {

/// Draws with `makeFirst()` and, from the first DeviceError on, its making included, with `makeSecond()`, which is not made before.
/// `onFallback` (may be empty) is told the reason once. Techniques that share `hasFailed` leave together, whichever of them the error met, and tell once: a device that is lost is not
/// tried again by each.
std::unique_ptr<Warp> makeFallbackWarp(const std::function<std::unique_ptr<Warp>()>& makeFirst,
                                       std::function<std::unique_ptr<Warp>()> makeSecond,
                                       std::function<void(const std::string& reason)> onFallback,
                                       std::shared_ptr<bool> hasFailed = std::make_shared<bool>(false));

}  // namespace warpscope
