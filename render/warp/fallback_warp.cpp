// Trying the first, remembering the frame for the second.
// See fallback_warp.h.
#include "render/warp/fallback_warp.h"

#include <utility>

#include "render/base/error.h"

namespace warpscope {
namespace {

class FallbackWarp final : public Warp {
 public:
  FallbackWarp(const std::function<std::unique_ptr<Warp>()>& makeFirst, std::function<std::unique_ptr<Warp>()> makeSecond,
               std::function<void(const std::string&)> onFallback, std::shared_ptr<bool> hasFailed)
      : makeSecond_(std::move(makeSecond)), onFallback_(std::move(onFallback)), hasFailed_(std::move(hasFailed)) {
    if (*hasFailed_) {
      leave();
      return;
    }
    try {
      warp_ = makeFirst();
    } catch (const DeviceError& error) {
      leave(error);
    }
  }

  void setFrame(SampleFramePtr frame, const WarpSettings& settings, const std::stop_token& stop) override {
    frame_ = std::move(frame);
    if (!isSecond_ && *hasFailed_) leave();
    if (!isSecond_) {
      try {
        return warp_->setFrame(frame_, settings, stop);
      } catch (const DeviceError& error) {
        leave(error);
      }
    }
    warp_->setFrame(frame_, settings, stop);
  }
  void draw(const Camera& camera, const WarpSettings& settings, WarpedImage& image, const std::stop_token& stop) override {
    attempt(settings, stop, [&] { warp_->draw(camera, settings, image, stop); });
  }
  DevicePicturePtr drawForScreen(const Camera& camera, const WarpSettings& settings, const glm::vec3& background, const PixelMarks& marks,
                                 const std::stop_token& stop) override {
    DevicePicturePtr picture;
    attempt(settings, stop, [&] { picture = warp_->drawForScreen(camera, settings, background, marks, stop); });
    return picture;
  }
  std::optional<DeviceTimings> deviceTimings() const override { return warp_->deviceTimings(); }

 private:
  template <class Work>
  void attempt(const WarpSettings& settings, const std::stop_token& stop, const Work& work) {
    if (isSecond_) return work();
    if (*hasFailed_) {
      leave();
    } else {
      try {
        return work();
      } catch (const DeviceError& error) {
        leave(error);
      }
    }
    warp_->setFrame(frame_, settings, stop);
    work();
  }

  void leave(const DeviceError& error) {
    if (!std::exchange(*hasFailed_, true) && onFallback_) onFallback_(error.what());
    leave();
  }
  void leave() {
    std::unique_ptr<Warp> second = makeSecond_();
    warp_ = std::move(second);
    isSecond_ = true;
  }

  std::unique_ptr<Warp> warp_;
  bool isSecond_ = false;
  SampleFramePtr frame_;
  const std::function<std::unique_ptr<Warp>()> makeSecond_;
  const std::function<void(const std::string&)> onFallback_;
  const std::shared_ptr<bool> hasFailed_;
};

}  // namespace

std::unique_ptr<Warp> makeFallbackWarp(const std::function<std::unique_ptr<Warp>()>& makeFirst,
                                       std::function<std::unique_ptr<Warp>()> makeSecond,
                                       std::function<void(const std::string&)> onFallback, std::shared_ptr<bool> hasFailed) {
  return std::make_unique<FallbackWarp>(makeFirst, std::move(makeSecond), std::move(onFallback), std::move(hasFailed));
}

}  // namespace warpscope
