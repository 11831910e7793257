// The image that the frame's samples form at their own camera.
// See hold_warp.h.
#include "render/warp/hold_warp.h"

#include <limits>

#include "render/core/parallel.h"

namespace warpscope {
namespace {

class HoldWarp final : public Warp {
 public:
  void setFrame(SampleFramePtr frame, const WarpSettings&, const std::stop_token&) override {
    frame_ = std::move(frame);
    pixels_.resize(0, 0);
    if (!frame_) return;
    const Camera& camera = frame_->camera;
    pixels_.resize(camera.width, camera.height, kNoSample);
    Image<float> depths(camera.width, camera.height, std::numeric_limits<float>::infinity());
    // A frame does not say which pixel a sample came from, but its camera does. Of several that share a pixel the nearest is seen.
    for (size_t i = 0; i < frame_->size(); ++i) {
      const Projection seen = project(camera, frame_->sphere(i).center);
      if (!(seen.forwardDepth > 0.0f) || !(seen.pixel.x >= 0.0f) || !(seen.pixel.y >= 0.0f)) continue;
      if (seen.pixel.x >= camera.width || seen.pixel.y >= camera.height) continue;
      const auto x = static_cast<uint32_t>(seen.pixel.x), y = static_cast<uint32_t>(seen.pixel.y);
      if (!(seen.forwardDepth < depths(x, y))) continue;
      depths(x, y) = seen.forwardDepth;
      pixels_(x, y) = static_cast<uint32_t>(i);
    }
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
    resolveColors(*frame_, image.samples, image.color);
  }

 private:
  SampleFramePtr frame_;
  Image<uint32_t> pixels_;  // sample seen in each pixel of the frame's own image
};

}  // namespace

std::unique_ptr<Warp> makeHoldWarp(const WarpResources&) { return std::make_unique<HoldWarp>(); }

}  // namespace warpscope
