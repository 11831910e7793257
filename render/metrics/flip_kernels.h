// The filters of FLIP for one viewing distance: what the eye does not resolve, and the features that it finds.
// Andersson et al. 2020, sections 4.1.1 and 4.2; see flip.h. Taps of less than 1e-7 of the middle one are left out.
#pragma once

#include <array>
#include <vector>

namespace warpscope {

/// Taps of an odd number, the middle one on the pixel itself.
using FilterTaps = std::vector<float>;

/// A filter along rows, then along columns.
struct SeparableTaps {
  FilterTaps rows, columns;  ///< of one length
};

struct FlipKernels {
  SeparableTaps achromatic, redGreen;
  std::array<SeparableTaps, 2> blueYellow;  ///< to be added up
  FilterTaps smooth, edge, point;           ///< of one length: an edge or point detector along one axis, smoothing along the other
};

/// `pixelsPerDegree`: 1..1000.
FlipKernels flipKernels(double pixelsPerDegree);

}  // namespace warpscope
