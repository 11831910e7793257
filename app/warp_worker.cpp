// Drawing only what changed since the last job.
// See warp_worker.h.
#include "app/warp_worker.h"

#include <chrono>

#include "app/picture.h"
#include "render/core/stopwatch.h"
#include "render/metrics/holes.h"

namespace warpscope {
namespace {

/// One technique at work, on the worker's thread.
class Easel {
 public:
  explicit Easel(gl::Platform platform) : platform_(platform) {}

  void paint(const WarpJob& job, WarpResult& result, const std::stop_token& stop) {
    result.technique = job.technique;
    result.marcher = job.marcher;
    result.requestId = job.frame ? job.frame->requestId : 0;
    try {
      prepare(job, stop);
      draw(job, stop);
    } catch (...) {
      warp_.reset();  // it may be half way between two frames
      picture_.reset();
      throw;
    }
    result.picture = picture_;
    result.buildMs = buildMs_;
    result.drawMs = drawMs_;
    if (job.reference && job.reference->camera == job.camera)
      result.holeFraction = countHoles(image_, job.reference->color).fraction();
  }

 private:
  void prepare(const WarpJob& job, const std::stop_token& stop) {
    const bool isOtherWarp = !warp_ || job.technique != last_.technique || job.marcher != last_.marcher;
    if (isOtherWarp) {
      warp_.reset();
      warp_ = job.technique->make(resources(job.marcher));
    }
    const bool isOtherBuild = job.frame != last_.frame || job.settings.sphereTracing != last_.settings.sphereTracing;
    if (isOtherWarp || isOtherBuild)
      buildMs_ = milliseconds([&] { warp_->setFrame(job.frame, job.settings, stop); });
    isDrawn_ = isDrawn_ && !isOtherWarp && !isOtherBuild && job.camera == last_.camera && job.settings == last_.settings;
    isConverted_ = isDrawn_ && isConverted_ && job.background == last_.background && job.uncovered == last_.uncovered;
    last_ = job;
    last_.reference.reset();
  }

  void draw(const WarpJob& job, const std::stop_token& stop) {
    if (!isDrawn_) drawMs_ = milliseconds([&] { warp_->draw(job.camera, job.settings, image_, stop); });
    isDrawn_ = true;
    if (!isConverted_) picture_ = std::make_shared<const Image<Rgba8>>(toScreen(image_, job.background, job.uncovered));
    isConverted_ = true;
  }

  WarpResources resources(const MarcherPtr& marcher) {
    return {marcher, [this]() -> gl::Context& {
              if (!context_) context_ = gl::makeHeadlessContext(platform_);
              return *context_;
            }};
  }

  const gl::Platform platform_;
  std::unique_ptr<gl::Context> context_;  // outlives the warp, whose objects are in it
  std::unique_ptr<Warp> warp_;
  WarpJob last_;
  WarpedImage image_;
  std::shared_ptr<const Image<Rgba8>> picture_;
  double buildMs_ = 0.0;
  double drawMs_ = 0.0;
  bool isDrawn_ = false;
  bool isConverted_ = false;
};

void marchReference(const ReferenceJob& job, ReferenceResult& result, const std::stop_token& stop) {
  auto image = std::make_shared<ReferenceImage>();
  image->camera = job.camera;
  job.marcher->render(job.camera, job.settings, image->color, stop);
  result.image = std::move(image);
}

}  // namespace

std::unique_ptr<WarpWorker> makeWarpWorker(gl::Platform platform, std::function<void()> onResult) {
  return std::make_unique<WarpWorker>(
      [platform]() -> WarpWorker::Work {
        auto easel = std::make_shared<Easel>(platform);
        return [easel](const WarpJob& job, WarpResult& result, const std::stop_token& stop) {
          easel->paint(job, result, stop);
        };
      },
      std::move(onResult));
}

std::unique_ptr<ReferenceWorker> makeReferenceWorker(std::function<void()> onResult) {
  return std::make_unique<ReferenceWorker>([]() -> ReferenceWorker::Work { return marchReference; }, std::move(onResult));
}

}  // namespace warpscope
