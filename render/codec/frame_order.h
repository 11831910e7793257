// Whether the samples of a frame are where coders rely on their being.
#pragma once

#include <cstdint>
#include <span>

#include "render/march/sample_frame.h"

namespace warpscope {

/// Whether every sample begins a ray or is the next of the one before, and none is one more than its ray may have.
bool countUp(std::span<const uint8_t> layers, int samplesPerRay);

/// Whether every sample is in a pixel of the picture, every ray in one after that of the ray before, and all samples of a ray in the same.
/// Without layers every sample is a ray.
bool areInOrder(const SampleFrame& frame);

/// Throws InputError for a frame, in host memory, that cannot be encoded.
void requireConsistent(const SampleFrame& frame);

}  // namespace warpscope
