// The frame before stays with its technique; then gaps are filled.
// See completed_warp.h.
#include "render/warp/completed_warp.h"

#include <utility>

#include "render/warp/fill.h"
#include "render/warp/kept_frames.h"
#include "render/warp/proxy_fill.h"
#include "render/warp/pull_push.h"

namespace warpscope {
namespace {

class CompletedWarp final : public Warp {
 public:
  CompletedWarp(const WarpDescriptor& technique, std::function<std::unique_ptr<Warp>()> make)
      : technique_(technique), make_(std::move(make)), warp_(make_()) {}

  void setFrame(SampleFramePtr frame, const WarpSettings& settings, const std::stop_token& stop) override {
    const auto most = static_cast<size_t>(settings.knobs.whole(kKeepKnob)) - 1;
    const SampleFramePtr before = std::exchange(frame_, nullptr);  // in case that building fails
    if (!frame) {
      kept_.limitTo(0);
    } else if (frame == before) {
      kept_.limitTo(most);
    } else if (!before) {
      kept_.limitTo(0);
    } else {
      warp_ = kept_.take(before, std::move(warp_), *frame, most);
    }
    builtWith_.set(kKeepKnob, settings.knobs[kKeepKnob]);  // how many there are changes none of them
    if (before && technique_.isBuiltAnew(builtWith_, settings.knobs)) kept_.rebuild(settings, stop);
    own().setFrame(frame, settings, stop);
    frame_ = std::move(frame);
    builtWith_ = settings.knobs;
  }

  void draw(const Camera& camera, const WarpSettings& settings, WarpedImage& image, const std::stop_token& stop) override {
    own().draw(camera, settings, image, stop);
    isCompleted_ = isCompletedFor(camera, settings);
    if (!isCompleted_) return;
    kept_.complete(camera, settings, image, stop);
    switch (fillOf(technique_, settings.knobs)) {
      case Fill::proxy:
        if (isFilledHere(Fill::proxy) && frame_->proxy) fillByProxy(camera, image, stop);
        break;
      case Fill::pullPush: fillGaps(image, stop); break;
      case Fill::automatic:
      case Fill::none: break;
    }
  }

  DevicePicturePtr drawForScreen(const Camera& camera, const WarpSettings& settings, const glm::vec3& background, const PixelMarks& marks,
                                 const std::stop_token& stop) override {
    if (isCompletedFor(camera, settings)) return nullptr;
    isCompleted_ = false;
    return own().drawForScreen(camera, settings, background, marks, stop);
  }

  /// What else is done is the host's.
  std::optional<DeviceTimings> deviceTimings() const override { return isCompleted_ || !warp_ ? std::nullopt : warp_->deviceTimings(); }

 private:
  /// The newest frame's technique; another one where that stays with a kept frame. Throws as the maker does, and may be called again.
  Warp& own() {
    if (!warp_) warp_ = make_();
    return *warp_;
  }
  bool isFilledHere(Fill fill) const { return fill == Fill::pullPush || (fill == Fill::proxy && !goesOnThroughProxy(technique_, frame_->settings.render.effects.mode)); }
  /// In the newest frame's own view nothing is missing: what is empty there is known to be.
  bool isCompletedFor(const Camera& camera, const WarpSettings& settings) const {
    return frame_ && camera != frame_->camera && (!kept_.empty() || isFilledHere(fillOf(technique_, settings.knobs)));
  }

  /// Of greatest values a frame knows each ray's alone: what the copy has may be greater than what is met. The greater of two is taken to be the more opaque one.
  void fillByProxy(const Camera& camera, WarpedImage& image, const std::stop_token& stop) {
    const bool isOfGreatest = frame_->settings.render.effects.mode == RenderMode::mip;
    proxyFill_.drawRays(*frame_, camera, stop, [&](uint32_t x, uint32_t y, const auto& lightOf) {
      if (image.samples(x, y) != kNoSample && !isOfGreatest) return;
      const glm::vec4 color = lightOf();
      if (!(color.a > image.color(x, y).a)) return;  // 0 in gaps
      image.color(x, y) = color;
      image.samples(x, y) = kFilled;
    });
  }

  const WarpDescriptor technique_;
  const std::function<std::unique_ptr<Warp>()> make_;
  std::unique_ptr<Warp> warp_;
  SampleFramePtr frame_;
  KnobValues builtWith_;  // the frame's and the kept ones' pictures
  KeptFrames kept_;
  ProxyFill proxyFill_;
  bool isCompleted_ = false;
};

}  // namespace

std::unique_ptr<Warp> makeCompletedWarp(const WarpDescriptor& technique, std::function<std::unique_ptr<Warp>()> make) {
  return std::make_unique<CompletedWarp>(technique, std::move(make));
}

}  // namespace warpscope
