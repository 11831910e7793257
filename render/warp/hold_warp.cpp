// The image that the frame's samples form at their own camera.
// See hold_warp.h.
#include "render/warp/hold_warp.h"

#include "render/core/parallel.h"
#include "render/march/own_picture.h"

namespace warpscope {
namespace {

class HoldWarp final : public Warp {
 public:
  void setFrame(SampleFramePtr frame, const WarpSettings&, const std::stop_token&) override {
    frame_ = std::move(frame);
    pixels_.resize(0, 0);
    if (frame_) pixels_ = ownPicture(*frame_);
  }

  void draw(const Camera& camera, const WarpSettings&, WarpedImage& image, const std::stop_token&) override {
    requireUsable(camera);
    image.samples.resize(camera.width, camera.height, kNoSample);
    image.color.resize(camera.width, camera.height);
    if (!frame_) return;
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
