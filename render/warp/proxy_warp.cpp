// A march for each pixel, in tiles on all cores.
// See proxy_warp.h.
#include "render/warp/proxy_warp.h"

#include "render/warp/proxy_fill.h"
#include "render/warp/proxy_warp_cuda.h"

namespace warpscope {
namespace {

class ProxyWarp final : public Warp {
 public:
  void setFrame(SampleFramePtr frame, const WarpSettings&, const std::stop_token&) override { frame_ = std::move(frame); }

  void draw(const Camera& camera, const WarpSettings&, WarpedImage& image, const std::stop_token& stop) override {
    requireUsable(camera);
    image.samples.resize(camera.width, camera.height, kNoSample);
    image.color.resize(camera.width, camera.height);
    if (!frame_ || !frame_->proxy) return;
    fill_.drawRays(*frame_, camera, stop, [&](uint32_t x, uint32_t y, const auto& lightOf) {
      const glm::vec4 color = lightOf();
      image.color(x, y) = color;
      if (color.a > 0.0f) image.samples(x, y) = kNotASample;
    });
  }

 private:
  SampleFramePtr frame_;
  ProxyFill fill_;
};

std::unique_ptr<Warp> makeProxyWarp(const WarpResources& resources) {
  if (resources.backend == Backend::cuda) return makeCudaProxyWarp();
  return std::make_unique<ProxyWarp>();
}

}  // namespace

constinit const WarpDescriptor kProxyWarp{
    .name = "proxy",
    .label = "Proxy",
    .summary = "the coarse copy of the volume alone, which came once: no frame at all",
    .runsOnCuda = true,
    .uses = {.proxy = true},
    .make = makeProxyWarp,
};

}  // namespace warpscope
