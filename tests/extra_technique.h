// A technique that no file of the program knows, with two knobs: what a new one has to say, and where it turns up by itself.
// It draws what `hold` draws, fainter and tinted.
#pragma once

#include "render/warp/warp.h"

namespace warpscope {

/// "fog", with the knobs `density` (a number) and `tint` (a choice).
const WarpDescriptor& extraTechnique();

}  // namespace warpscope
