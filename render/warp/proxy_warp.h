// The coarse copy of the volume alone, marched for the camera: the honest baseline of all that warps, and for small volumes a serious rival.
// See march/proxy_march.h.
#pragma once

#include "render/warp/warp.h"

namespace warpscope {

extern const WarpDescriptor kProxyWarp;

}  // namespace warpscope
