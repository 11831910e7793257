// Structural similarity in the two forms that stability.h compares with the program's own: as it is printed, in single precision, and in double.
// Wang, Bovik, Sheikh, Simoncelli 2004, section III B; the program's form is render/metrics/ssim.h.
#pragma once

#include "render/metrics/displayed.h"

namespace warpscope {

/// By variances E[x^2] - E[x]^2 and covariance E[xy] - E[x] E[y] of floats. Planes of one size, at least 11 pixels a side.
double textbookSsim(const ColorPlanes& a, const ColorPlanes& b);

/// Of one channel, by sums of squared deviations in double. Planes of one size, at least 11 pixels a side.
double exactSsim(const Image<float>& a, const Image<float>& b);

}  // namespace warpscope
