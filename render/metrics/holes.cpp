// Counting holes.
// See holes.h.
#include "render/metrics/holes.h"

#include <cmath>

#include "render/base/error.h"

namespace warpscope {

HoleCount countHoles(const WarpedImage& image, const Image<glm::vec4>& reference) {
  if (image.samples.width() != reference.width() || image.samples.height() != reference.height())
    throw InputError("counting holes needs two images of one size");
  HoleCount count;
  for (size_t i = 0; i < reference.size(); ++i) {
    if (std::isnan(reference[i].a)) throw InputError("counting holes: a pixel of the reference is not a number");
    if (reference[i].a < kShownAlpha) continue;
    ++count.shown;
    count.holes += image.samples[i] == kNoSample;
    count.filled += image.samples[i] == kFilled;
  }
  return count;
}

}  // namespace warpscope
