// Cameras and sizes.
// See live_view.h.
#include "app/session/live_view.h"

#include <algorithm>
#include <exception>

#include "render/core/image.h"

namespace warpscope {
namespace {

/// Panels draw at most this many pixels unless the user says how many.
constexpr uint64_t kFluentPixels = 600 * 1000;

}  // namespace

void LiveView::begin(const View& view) {
  wanted_ = usable_ = view;
  error_.clear();
}

bool LiveView::place(const Scene& scene) {
  const glm::uvec2 size = pictureSize();
  try {
    camera_ = makeCamera(scene, wanted_, size.x, size.y);
  } catch (const std::exception& error) {
    error_ = error.what();
    const bool hasOther = wanted_ != usable_;
    wanted_ = usable_;
    return hasOther && place(scene);
  }
  if (wanted_ != usable_) error_.clear();
  usable_ = wanted_;
  return true;
}

uint32_t LiveView::screenPixels() const {
  uint32_t edge = std::max(1u, screenPixels_);
  if (screenPixels_ == 0)
    while (uint64_t{areaPx_.x / edge} * (areaPx_.y / edge) > kFluentPixels) ++edge;
  return edge;
}

glm::uvec2 LiveView::pictureSize() const {
  if (areaPx_.x == 0 || areaPx_.y == 0) return glm::uvec2(0);
  return glm::clamp(areaPx_ / screenPixels(), glm::uvec2(1), glm::uvec2(kMaxImageSide));
}

glm::uvec2 LiveView::sizeOfSide(uint32_t sidePx) const {
  const glm::uvec2 picture = pictureSize();
  if (picture.x == 0) return picture;
  const double scale = static_cast<double>(sidePx) / std::max(picture.x, picture.y);
  return glm::max(glm::uvec2(1), glm::uvec2(glm::round(glm::dvec2(picture) * scale)));
}

Camera LiveView::cameraOfSize(const glm::uvec2& size) const {
  Camera camera = camera_;
  camera.width = size.x;
  camera.height = size.y;
  return camera;
}

}  // namespace warpscope
