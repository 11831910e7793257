// Flicker: what a technique's pictures do from view to view along a path that the ground truth's do not.
// FLIP (flip.h) of the difference of successive pictures against that of successive references, as displayed, 0.5 + 0.5 * difference, so that no
// change is a middle grey on both sides. Single pictures may all be off by the same and not flicker; popping and swimming shows here. Our own
// measure, in the manner of temporal differences in video quality metrics.
#pragma once

#include <optional>

#include "render/metrics/flip.h"

namespace warpscope {

/// Follows one technique along one path. Used from one thread at a time.
class FlickerMeter {
 public:
  /// `background` is linear. Throws InputError if `pixelsPerDegree` (of the field of view) is not within 1..1000.
  explicit FlickerMeter(const glm::vec3& background, float pixelsPerDegree = kFlipPixelsPerDegree);

  /// The next view: the technique's picture and the ground truth, linear and premultiplied, of the size of those before. Throws InputError
  /// if a size differs, an image is empty or a pixel is not finite; the view then does not count.
  void add(const Image<glm::vec4>& picture, const Image<glm::vec4>& reference);

  /// Mean of FLIP over the steps from view to view so far, 0..1, 0: changes as the ground truth does. Nothing before the second view.
  std::optional<double> mean() const;
  /// FLIP of the last step, for each pixel; empty before the second view.
  const Image<float>& lastMap() const { return map_; }

 private:
  glm::vec3 background_;
  float pixelsPerDegree_;
  ColorPlanes picture_, reference_;  // sRGB, of the last view
  Image<float> map_;
  double sum_ = 0.0;
  size_t steps_ = 0;
};

}  // namespace warpscope
