// Peak signal-to-noise ratio of two pictures as a display shows them.
// 10 log10(1 / MSE) over red, green and blue after the sRGB curve, composited over a background.
#pragma once

#include "render/metrics/displayed.h"

namespace warpscope {

/// Decibels; infinite for equal images. Both images are linear and premultiplied and of one size; `background` is linear.
/// Throws InputError if the sizes differ, an image is empty, or a pixel is not finite.
double psnrSrgb(const Image<glm::vec4>& image, const Image<glm::vec4>& reference, const glm::vec3& background);

/// Sum of squared differences over all pixels of planes of one size, added up as psnrSrgb does.
double sumOfSquares(const ColorPlanes& a, const ColorPlanes& b);

/// The ratio for `squares`, a sum of squared differences over red, green and blue of `pixels` pixels; infinite for 0.
double psnrOfSquares(double squares, size_t pixels);

}  // namespace warpscope
