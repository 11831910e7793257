// Everything that is measured of a warped picture against the ground truth, in one go.
// The formulas are those of psnr.h, ssim.h, flip.h and holes.h; errors split by what the server's frame could know: visibility.h.
#pragma once

#include <memory>
#include <optional>

#include "render/metrics/flip.h"
#include "render/metrics/visibility.h"
#include "render/warp/warp.h"

namespace warpscope {

/// Of a picture against a reference, both over one background. PSNRs in dB are infinite where nothing differs.
struct PictureErrors {
  double psnrDb = 0.0;        ///< of values as displayed (sRGB)
  double psnrLinearDb = 0.0;  ///< of linear light, 0..1, where differences in dark places count less
  double ssim = 0.0;          ///< -1..1; 1: equal
  double flip = 0.0;          ///< mean, 0..1; 0: equal
  double holeFraction = 0.0;  ///< 0..1, see holes.h
  double filledFraction = 0.0;  ///< likewise

  /// Over the pixels of one kind; nothing without a mask or without such pixels. FLIP is the mean of the whole picture's map there.
  std::optional<double> flipVisible, flipDisoccluded;
  std::optional<double> psnrVisibleDb, psnrDisoccludedDb;  ///< as psnrDb
};

/// A ground truth, prepared once for every picture that is compared with it: what the metrics derive from it alone is kept.
/// errorsOf may be called from several threads at once.
class PictureJudge {
 public:
  /// `reference` is linear and premultiplied, `background` linear. Throws InputError if the image is empty, a pixel is not finite, or
  /// `pixelsPerDegree` (of the field of view, for FLIP) is not within 1..1000.
  PictureJudge(const Image<glm::vec4>& reference, const glm::vec3& background, float pixelsPerDegree = kFlipPixelsPerDegree);
  ~PictureJudge();
  PictureJudge(PictureJudge&&) noexcept;
  PictureJudge& operator=(PictureJudge&&) noexcept;

  /// `map`: FLIP per pixel, left there if not null. `mask`: what the frame knew of each pixel of the reference (visibilityOf), or null.
  /// Throws InputError if a size differs from the reference's or a pixel is not finite.
  PictureErrors errorsOf(const WarpedImage& image, const Image<Visibility>* mask = nullptr, Image<float>* map = nullptr) const;

 private:
  struct Prepared;
  std::unique_ptr<const Prepared> prepared_;
};

}  // namespace warpscope
