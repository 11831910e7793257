// Marching the truth.
// See ground_truth.h.
#include "app/experiment/ground_truth.h"

#include <algorithm>

namespace warpscope {

GroundTruth::GroundTruth(const Scene& scene, MarcherPtr marcher, const RenderSettings& render, uint32_t width, uint32_t height)
    : scene_(scene), marcher_(std::move(marcher)), render_(render), sampled_{render, {}}, width_(width), height_(height) {
  sampled_.sample.heuristic = Heuristic::median;
}

Camera GroundTruth::camera(double angleDeg, uint32_t sidePx) const {
  const double scale = static_cast<double>(sidePx) / std::max(width_, height_);
  const auto scaled = [&](uint32_t length) { return std::max(1u, static_cast<uint32_t>(scale * length + 0.5)); };
  View view = scene_.views.front();
  view.angleDeg += angleDeg;
  return makeCamera(scene_, view, scaled(width_), scaled(height_));
}

Camera GroundTruth::camera(double angleDeg) const { return camera(angleDeg, std::max(width_, height_)); }

const Truth& GroundTruth::at(double angleDeg, const std::stop_token& stop) {
  std::unique_ptr<Truth>& truth = truths_[angleDeg];
  if (truth) return *truth;
  const Camera view = camera(angleDeg);
  Image<glm::vec4> color;
  marcher_->render(view, render_, color, stop);
  PictureJudge judge(color, scene_.background);
  truth = std::make_unique<Truth>(Truth{view, std::move(color), std::move(judge)});
  return *truth;
}

const Seen& GroundTruth::seenAt(double angleDeg, const std::stop_token& stop) {
  if (const auto known = seen_.find(angleDeg); known != seen_.end()) return known->second;
  if (!firstView_) firstView_ = std::make_unique<SampleFrame>(marcher_->march(camera(0.0), sampled_, stop));
  Seen seen{visibilityOf(*firstView_, marcher_->march(camera(angleDeg), sampled_, stop)), 0.0};
  const auto count = [&](Visibility kind) { return static_cast<double>(std::count(seen.visibility.begin(), seen.visibility.end(), kind)); };
  const double hidden = count(Visibility::disoccluded), shown = hidden + count(Visibility::visible);
  if (shown > 0.0) seen.disoccludedFraction = hidden / shown;
  return seen_.emplace(angleDeg, std::move(seen)).first->second;
}

PictureErrors GroundTruth::floorAt(double angleDeg, const std::stop_token& stop) {
  const Truth& truth = at(angleDeg, stop);
  RenderSettings finer = render_;
  finer.step = std::max(0.5f * render_.step, static_cast<float>(kStepRange.lowest));
  WarpedImage image;
  marcher_->render(truth.camera, finer, image.color, stop);
  image.samples.reshape(image.color.width(), image.color.height());
  std::fill(image.samples.begin(), image.samples.end(), kNotASample);
  return truth.judge.errorsOf(image, &seenAt(angleDeg, stop).visibility);
}

}  // namespace warpscope
