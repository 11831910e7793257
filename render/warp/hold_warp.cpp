// The image that the frame's samples form at their own camera.
// See hold_warp.h.
#include "render/warp/hold_warp.h"

#include <algorithm>
#include <cstdint>
#include <cstdlib>

#include "render/core/parallel.h"
#include "render/march/own_picture.h"

namespace warpscope {
namespace {

class HoldWarp final : public Warp {
 public:
  void setFrame(SampleFramePtr frame, const WarpSettings&, const std::stop_token&) override {
    frame_ = nullptr;  // in case that the picture cannot be made
    pixels_.resize(0, 0);
    if (frame) pixels_ = ownPicture(*frame);
    frame_ = std::move(frame);
  }

  void draw(const Camera& camera, const WarpSettings&, WarpedImage& image, const std::stop_token&) override {
    requireUsable(camera);
    image.samples.resize(camera.width, camera.height, kNoSample);
    image.color.resize(camera.width, camera.height);
    if (!frame_) return;
    if (!isOfItsShape(camera)) return drawOtherShape(camera, image);
    // Nearest pixel: the held image fills the view, whatever the server's resolution.
    parallelForRanges(camera.height, 16, [&](size_t begin, size_t end) {
      for (size_t y = begin; y < end; ++y) {
        const size_t fromY = (2 * y + 1) * pixels_.height() / (2 * camera.height);
        for (size_t x = 0; x < camera.width; ++x) {
          const size_t fromX = (2 * x + 1) * pixels_.width() / (2 * camera.width);
          image.samples(static_cast<uint32_t>(x), static_cast<uint32_t>(y)) =
              pixels_(static_cast<uint32_t>(fromX), static_cast<uint32_t>(fromY));
        }
      }
    });
    resolveRayColors(*frame_, image.samples, image.color);
  }

 private:
  /// Whether the view's sides are as those of the held image, as far as whole pixels can be.
  bool isOfItsShape(const Camera& camera) const {
    const auto ofView = int64_t{camera.width} * pixels_.height(), ofImage = int64_t{camera.height} * pixels_.width();
    return std::abs(ofView - ofImage) <= std::max({camera.width, camera.height, pixels_.width(), pixels_.height()});
  }

  /// In the middle and undistorted: narrower sides, which cameras see as much on of the volume (makeCamera), are equally long. Beside it nothing is.
  void drawOtherShape(const Camera& camera, WarpedImage& image) const {
    const glm::i64vec2 view(camera.width, camera.height), held(pixels_.width(), pixels_.height());
    const int64_t ofView = std::min(view.x, view.y), ofHeld = std::min(held.x, held.y);
    // Twice the place in the held image; nothing outside of it.
    const auto placeOf = [&](int64_t pixel, int axis) { return held[axis] * ofView + (2 * pixel + 1 - view[axis]) * ofHeld; };
    parallelForRanges(camera.height, 16, [&](size_t begin, size_t end) {
      for (size_t y = begin; y < end; ++y)
        for (size_t x = 0; x < camera.width; ++x) {
          const glm::i64vec2 twice(placeOf(static_cast<int64_t>(x), 0), placeOf(static_cast<int64_t>(y), 1));
          if (twice.x < 0 || twice.y < 0) continue;
          const glm::i64vec2 from = twice / (2 * ofView);
          if (from.x < held.x && from.y < held.y)
            image.samples(static_cast<uint32_t>(x), static_cast<uint32_t>(y)) = pixels_(static_cast<uint32_t>(from.x), static_cast<uint32_t>(from.y));
        }
    });
    resolveRayColors(*frame_, image.samples, image.color);
  }

  SampleFramePtr frame_;
  Image<uint32_t> pixels_;  // first sample of the ray seen in each pixel of the frame's own image
};

std::unique_ptr<Warp> makeHoldWarp(const WarpResources&) {
  return std::make_unique<HoldWarp>();
}

}  // namespace

constinit const WarpDescriptor kHoldWarp{
    .name = "hold",
    .label = "Hold",
    .summary = "the last image, not warped: what image-streaming viewers show",
    .make = makeHoldWarp,
};

}  // namespace warpscope
