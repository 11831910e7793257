// A frame whose coarse copy of the volume is seen by another transfer function than it came with.
#pragma once

#include "render/march/sample_frame.h"

namespace warpscope {

/// The same frame where it has no copy, or one that is by that function already; else one with its samples and segments, and the copy by that function.
SampleFramePtr classifiedBy(const TransferFunction& function, const SampleFramePtr& frame);

}  // namespace warpscope
