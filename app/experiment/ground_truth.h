// The truth for each angle of a sweep: the volume marched for that camera, ready to judge pictures.
// Marched when first asked for, and kept.
#pragma once

#include <map>
#include <memory>
#include <stop_token>

#include "app/scene/scene.h"
#include "render/march/marcher.h"
#include "render/metrics/picture_errors.h"

namespace warpscope {

struct Truth {
  Camera camera;
  Image<glm::vec4> color;
  PictureJudge judge;
};

/// What the first view's camera could see of each pixel of another, by samples where half the light comes from before them.
struct Seen {
  Image<Visibility> visibility;
  double disoccludedFraction = 0.0;  ///< among what is not empty
};

class GroundTruth {
 public:
  /// Pictures of `width` x `height`; `render`: what the truth is. The scene must outlive this.
  GroundTruth(const Scene& scene, MarcherPtr marcher, const RenderSettings& render, uint32_t width, uint32_t height);

  /// The first view, turned by `angleDeg` about the vertical axis, as an image of which the longer side has `sidePx` pixels.
  Camera camera(double angleDeg, uint32_t sidePx) const;
  /// As pictures see it.
  Camera camera(double angleDeg) const;

  /// Throws as marching does.
  const Truth& at(double angleDeg, const std::stop_token& stop);
  const Seen& seenAt(double angleDeg, const std::stop_token& stop);

  /// The truth against one marched with half its step.
  PictureErrors floorAt(double angleDeg, const std::stop_token& stop);

 private:
  const Scene& scene_;
  MarcherPtr marcher_;
  RenderSettings render_;
  MarchSettings sampled_;  // for what the camera could see
  uint32_t width_, height_;
  std::map<double, std::unique_ptr<Truth>> truths_;
  std::map<double, Seen> seen_;
  std::unique_ptr<SampleFrame> firstView_;
};

}  // namespace warpscope
