// See host_frame_warp.h.
#include "render/warp/host_frame_warp.h"

#include <utility>

namespace warpscope {
namespace {

class HostFrameWarp final : public Warp {
 public:
  explicit HostFrameWarp(std::unique_ptr<Warp> warp) : warp_(std::move(warp)) {}

  void setFrame(SampleFramePtr frame, const WarpSettings& settings, const std::stop_token& stop) override { warp_->setFrame(onHost(frame), settings, stop); }
  void draw(const Camera& camera, const WarpSettings& settings, WarpedImage& image, const std::stop_token& stop) override { warp_->draw(camera, settings, image, stop); }
  DevicePicturePtr drawForScreen(const Camera& camera, const WarpSettings& settings, const glm::vec3& background, const PixelMarks& marks,
                                 const std::stop_token& stop) override {
    return warp_->drawForScreen(camera, settings, background, marks, stop);
  }
  std::optional<DeviceTimings> deviceTimings() const override { return warp_->deviceTimings(); }

 private:
  const std::unique_ptr<Warp> warp_;
};

}  // namespace

std::unique_ptr<Warp> makeHostFrameWarp(std::unique_ptr<Warp> warp) { return std::make_unique<HostFrameWarp>(std::move(warp)); }

}  // namespace warpscope
