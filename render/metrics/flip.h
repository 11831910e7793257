// FLIP: how different two pictures look when they are shown one after the other at the same place, and where.
// Andersson, Nilsson, Akenine-Moeller, Oskarsson, Astroem, Fairchild 2020, "FLIP: A difference evaluator for alternating images" (the
// evaluator for low dynamic range), sections 4 and 5; its constants are those of the paper.
#pragma once

#include <array>

#include "render/metrics/displayed.h"
#include "render/metrics/flip_kernels.h"

namespace warpscope {

/// Pixels per degree of the field of view: a display 0.7 m wide with 3840 pixels, seen from 0.7 m (the paper's default, about 67).
inline constexpr float kFlipPixelsPerDegree = 3840.0f * 3.14159265f / 180.0f;

/// What the mean differs by from what the authors' flip-evaluator says of the same pictures; their filters and ours are
/// both float, cut off at 3 deviations.
inline constexpr double kFlipError = 1e-4;
/// What it is off by for pictures of one colour each, which filters leave as they are but for rounding. That of a* and b*,
/// a few roundings of 500, is about 2e-4: to the power of 0.7, which is infinitely steep where colours hardly differ, and
/// at 0.06 for each unit it becomes this.
inline constexpr double kFlipErrorOfUniform = 2e-4;

/// Throws InputError unless `pixelsPerDegree` is within 1..1000.
void requireFlipResolution(float pixelsPerDegree);

struct FlipResult {
  double mean = 0.0;  ///< 0: no difference, 1: the largest
  Image<float> map;   ///< 0..1, for each pixel
};

/// Both images are linear and premultiplied and of one size; `background` is linear. Throws InputError if the sizes differ, an image is empty, a
/// pixel is not finite, or `pixelsPerDegree` is not within 1..1000.
FlipResult flip(const Image<glm::vec4>& image, const Image<glm::vec4>& reference, const glm::vec3& background,
                float pixelsPerDegree = kFlipPixelsPerDegree);

/// The same for many images and one reference, of which what the eye makes of it is kept.
class FlipReference {
 public:
  /// Linear values, not empty. Throws InputError if `pixelsPerDegree` is not within 1..1000.
  FlipReference(const ColorPlanes& reference, float pixelsPerDegree);
  /// Of an image's linear values; of the reference's size. The mean; the difference of each pixel is left in `map`.
  double difference(const ColorPlanes& image, Image<float>& map) const;

 private:
  FlipKernels kernels_;
  std::array<Image<float>, 5> seen_;  // CIELAB with the Hunt effect, strengths of edges and of points
};

}  // namespace warpscope
