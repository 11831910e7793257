// Structural similarity of two pictures as a display shows them.
// Wang, Bovik, Sheikh, Simoncelli 2004: Gaussian window of 11x11 pixels and deviation 1.5, K1 = 0.01, K2 = 0.03, population variances; the mean
// over red, green and blue and over all pixels whose window lies inside the image.
#pragma once

#include <array>

#include "render/metrics/displayed.h"

namespace warpscope {

/// What ssimSrgb is off by: at most (flat areas whose levels are far apart), and where levels differ by less than 0.1.
inline constexpr double kSsimError = 1.2e-4;
inline constexpr double kSsimErrorOfAlike = 2e-5;

/// -1..1, 1 for equal images. Both are linear and premultiplied and of one size; `background` is linear. In images of
/// fewer than 11 pixels a side windows reach over the border, where the outermost pixel goes on. Throws InputError if
/// the sizes differ, an image is empty, or a pixel is not finite. Exactly 1 for equal images; as precise as kSsimError
/// and kSsimErrorOfAlike say.
double ssimSrgb(const Image<glm::vec4>& image, const Image<glm::vec4>& reference, const glm::vec3& background);

/// The same for many images and one reference, whose means and variances are kept.
class SsimReference {
 public:
  /// sRGB values of the reference, which must stay; not empty.
  explicit SsimReference(const ColorPlanes& reference);
  /// Of an image's sRGB values; of the reference's size.
  double similarity(const ColorPlanes& image) const;

 private:
  struct Channel {
    Image<float> means, variances;
  };
  const ColorPlanes* reference_;
  std::array<Channel, 3> channels_;
};

}  // namespace warpscope
