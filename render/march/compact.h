// Leaves out the pixels that found nothing, in parallel and in order.
// Count, scan, copy (cf. Blelloch 1990, section 1.3).
#pragma once

#include <span>

#include "render/march/sample_frame.h"

namespace warpscope {

/// Copies the samples with a radius code other than 0, and their colours, to `frame`, keeping order. Both inputs have the same length.
void compact(std::span<const PackedSample> samples, std::span<const Rgba8> colors, SampleFrame& frame);

}  // namespace warpscope
