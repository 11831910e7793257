// Metrics of pictures on a CUDA device, fast enough for every picture that a window shows.
// PictureJudge (picture_errors.h) there: the same formulas (display_curve.h, ssim_formulas.h, flip_formulas.h, flip_kernels.h), agreeing with the
// CPU to 1e-5 (dB for PSNRs).
#pragma once

#include <memory>

#include "render/core/device_picture.h"
#include "render/metrics/flip.h"

namespace warpscope {

/// As the fields of PictureErrors, and what they took.
struct DeviceErrors {
  double psnrDb = 0.0;
  double psnrLinearDb = 0.0;
  double ssim = 0.0;
  double flip = 0.0;

  /// Milliseconds between events on the device. FLIP's and SSIM's hold what only they need; both need the picture's planes first.
  double planesAndPsnrMs = 0.0, ssimMs = 0.0, flipMs = 0.0;
};

/// A ground truth in the device's memory, and the pictures that are compared with it. Pictures are either linear and premultiplied in host
/// memory, or finished for the screen on the device (Warp::drawForScreen): then 8 bit, as a person sees them. Used from one thread at a time.
class DevicePictureJudge {
 public:
  virtual ~DevicePictureJudge() = default;

  /// Throws InputError if the picture is empty or a pixel is not finite; the judge then has no reference. Throws DeviceError.
  virtual void setReference(const Image<glm::vec4>& reference) = 0;
  virtual void setReference(const DevicePicture& reference) = 0;

  /// `map`: FLIP per pixel, copied there if not null. Throws InputError without a reference, if the size is not the reference's, or if a pixel
  /// is not finite; DeviceError.
  virtual DeviceErrors errorsOf(const Image<glm::vec4>& picture, Image<float>* map = nullptr) = 0;
  virtual DeviceErrors errorsOf(const DevicePicture& picture, Image<float>* map = nullptr) = 0;
};

/// `background` is linear. Throws InputError if `pixelsPerDegree` is not within 1..1000, DeviceError if there is no device or no CUDA in this build.
std::unique_ptr<DevicePictureJudge> makeCudaPictureJudge(const glm::vec3& background, float pixelsPerDegree = kFlipPixelsPerDegree);

}  // namespace warpscope
