// Structural similarity of two pictures as a display shows them.
// Wang, Bovik, Sheikh, Simoncelli 2004: Gaussian window of 11x11 pixels and deviation 1.5, K1 = 0.01, K2 = 0.03, population variances; the mean
// over red, green and blue and over all pixels whose window lies inside the image.
#pragma once

#include "render/core/host_device.h"
#include "render/core/image.h"

namespace warpscope {

/// -1..1, 1 for equal images. Both are linear and premultiplied and of one size; `background` is linear. In images of fewer than 11 pixels a side
/// windows reach over the border, where the outermost pixel goes on. Throws InputError if the sizes differ, an image is empty, or a pixel is not
/// finite.
double ssimSrgb(const Image<glm::vec4>& image, const Image<glm::vec4>& reference, const glm::vec3& background);

}  // namespace warpscope
