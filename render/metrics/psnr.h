// Peak signal-to-noise ratio of two pictures as a display shows them.
// 10 log10(1 / MSE) over red, green and blue after the sRGB curve, composited over a background.
#pragma once

#include "render/metrics/displayed.h"

namespace warpscope {

/// What the root of the mean squared difference is off by: what two pictures display is off by kRmsError together, and
/// sums of 512 squares in float make kRmsRelativeError of the root. In decibels that is 8.7 times its
/// share of the root: 1e-4 dB for pictures that differ by a tenth, 0.01 dB for pictures that differ by 5e-4, and
/// nothing that can be relied upon where they differ by less than rounding.
inline constexpr double kRmsError = 5e-7;
inline constexpr double kRmsRelativeError = 2e-6;

/// Decibels, as precise as kRmsError says; infinite for equal images. Both images are linear and premultiplied and of
/// one size; `background` is linear. Throws InputError if the sizes differ, an image is empty, or a pixel is not
/// finite.
double psnrSrgb(const Image<glm::vec4>& image, const Image<glm::vec4>& reference, const glm::vec3& background);

/// Sum of squared differences over all pixels of planes of one size, added up as psnrSrgb does.
double sumOfSquares(const ColorPlanes& a, const ColorPlanes& b);

/// The ratio for `squares`, a sum of squared differences over red, green and blue of `pixels` pixels; infinite for 0.
double psnrOfSquares(double squares, size_t pixels);

}  // namespace warpscope
