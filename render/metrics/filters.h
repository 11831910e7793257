// Filtering planes along rows and columns, in parallel. Beyond the border the outermost pixel goes on.
// Kernels have an odd number of taps, the middle one on the pixel itself; they are not mirrored.
#pragma once

#include <span>

#include "render/core/image.h"

namespace warpscope {

/// out(x, y) = sum over j of kernel[j] * in(x + j - radius, y). `out` gets the size of `in` and must be another image.
void filterRows(const Image<float>& in, std::span<const float> kernel, Image<float>& out);

/// out(x, y) = sum over j of kernel[j] * in(x, y + j - radius), added to what is there if `adds`.
void filterColumns(const Image<float>& in, std::span<const float> kernel, Image<float>& out, bool adds = false);

}  // namespace warpscope
