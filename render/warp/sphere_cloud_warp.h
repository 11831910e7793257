// What techniques that draw a frame as a cloud of spheres have in common: the frame, its spheres, cameras that are refused.
// One sphere a sample, as Zellmann 2020.
#pragma once

#include <span>
#include <vector>

#include "render/warp/warp.h"

namespace warpscope {

class SphereCloudWarp : public Warp {
 public:
  void setFrame(SampleFramePtr frame, const WarpSettings& settings, const std::stop_token& stop = {}) final;
  void draw(const Camera& camera, const WarpSettings& settings, WarpedImage& image, const std::stop_token& stop = {}) final;

 protected:
  /// Takes a new frame and the spheres of its samples, in their order; both stay where they are until the next frame.
  virtual void build(const SampleFrame& frame, std::span<const Sphere> spheres, const WarpSettings& settings) = 0;

  /// Draws what was built last, for a usable camera. Both images may have any size.
  virtual void drawSpheres(const SampleFrame& frame, const Camera& camera, const WarpSettings& settings, WarpedImage& image,
                           const std::stop_token& stop) = 0;

  std::span<const Sphere> spheres() const { return spheres_; }

 private:
  SampleFramePtr frame_;
  std::vector<Sphere> spheres_;
};

}  // namespace warpscope
