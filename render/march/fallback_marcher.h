// A marcher that leaves a device which fails it, and goes on elsewhere.
// What a device may do: run out of memory, be unplugged, reset or claimed by another (CUDA Runtime API, error codes).
#pragma once

#include <functional>
#include <string>

#include "render/march/marcher.h"

namespace warpscope {

/// Marches with `makeFirst()` and, from the first DeviceError on, its making included, with `makeSecond()`, which is not made before.
/// `onFallback` (may be empty) is told the reason once, on the thread that met it; twins, and those of other transfer functions, leave together.
MarcherPtr makeFallbackMarcher(const std::function<MarcherPtr()>& makeFirst, std::function<MarcherPtr()> makeSecond,
                               std::function<void(const std::string& reason)> onFallback);

}  // namespace warpscope
