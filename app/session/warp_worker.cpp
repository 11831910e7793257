// Drawing only what changed since the last job.
// See warp_worker.h.
#include "app/session/warp_worker.h"

#include <chrono>
#include <utility>

#include "app/picture/picture.h"
#include "app/shell/log.h"
#include "render/base/error.h"
#include "render/base/recent_need.h"
#include "render/base/stopwatch.h"

namespace warpscope {
namespace {

/// Of a picture on show: some tenths of a second without a GPU.
constexpr int kTimedRuns = 5;

/// One technique at work, on the worker's thread.
class Easel {
 public:
  Easel(gl::Platform platform, WarpResources resources) : platform_(platform), resources_(std::move(resources)) {
    resources_.context = [this]() -> gl::Context& {
      if (!context_) {
        context_ = gl::makeHeadlessContext(platform_);
        logDetail("OpenGL of a panel: " + std::string(context_->platformName()) + ", " + context_->renderer());
      }
      return *context_;
    };
  }

  void paint(const WarpJob& job, WarpResult& result, const std::stop_token& stop) {
    result.job = job;
    if (job.timedAs) return time(job, result, stop);
    try {
      prepare(job, stop);
      draw(job, stop);
    } catch (...) {
      warp_.reset();  // it may be half way between two frames
      picture_ = {};
      throw;
    }
    result.picture = picture_;
    result.isDrawn = std::exchange(isDrawn_, false);
    result.buildMs = buildMs_;
    result.drawMs = drawMs_;
    result.finishedAt = std::chrono::steady_clock::now();
    const bool isOtherReference = std::exchange(reference_, job.reference) != job.reference;
    if (job.reference) result.judged = imageToJudge(job, isOtherReference, stop);
  }

 private:
  /// Does again what the last picture took, nothing of which is shown.
  void time(const WarpJob& job, WarpResult& result, const std::stop_token& stop) {
    const bool isLast = warp_ && job.technique == last_.technique && job.frame == last_.frame && job.camera == last_.camera && job.settings == last_.settings;
    if (!isLast) return;
    try {
      result.timed = measurePicture(Measuring::inWholeRuns(kTimedRuns, stop), {*warp_, job.settings, job.background}, codec_, *job.timedAs, job.frame,
                                    job.camera);
    } catch (const OperationCancelled&) {
      throw;  // between two runs: the technique is whole
    } catch (...) {
      warp_.reset();
      throw;
    }
  }

  /// Whether what techniques and pictures keep for a frame as large as some earlier one is to go.
  bool isOversized(const WarpJob& job) {
    if (!job.frame || job.frame == last_.frame) return false;
    return need_.exceedsRecent(job.frame->size() + size_t{job.camera.width} * job.camera.height);
  }

  void prepare(const WarpJob& job, const std::stop_token& stop) {
    if (isOversized(job)) {
      warp_.reset();
      image_ = std::make_shared<WarpedImage>();
      isHandedOut_ = isInHostMemory_ = false;
      picture_ = {};
      last_.frame.reset();
      giveBackFreedMemory();
    }
    const bool isOtherWarp = !warp_ || job.technique != last_.technique || job.marcher != last_.marcher;
    if (isOtherWarp) {
      warp_.reset();
      resources_.marcher = job.marcher;
      warp_ = makeWarp(*job.technique, resources_);
    }
    const bool isOtherBuild = job.frame != last_.frame || job.technique->isBuiltAnew(last_.settings.knobs, job.settings.knobs);
    if (isOtherWarp || isOtherBuild)
      buildMs_ = milliseconds([&] { warp_->setFrame(job.frame, job.settings, stop); });
    const bool isOtherView = isOtherWarp || isOtherBuild || job.camera != last_.camera || job.settings != last_.settings;
    if (isOtherView) isInHostMemory_ = false;
    if (isOtherView || job.background != last_.background || job.uncovered != last_.uncovered) picture_ = {};
    last_ = job;
    last_.reference.reset();
  }

  void draw(const WarpJob& job, const std::stop_token& stop) {
    if (picture_) return;
    const bool isThere = isInHostMemory_;
    const double tookMs = milliseconds([&] {
      picture_.device = warp_->drawForScreen(job.camera, job.settings, job.background, job.uncovered, stop);
      if (!picture_) drawToHost(job, stop);
    });
    isDrawn_ = picture_ || !isThere;
    if (isDrawn_) drawMs_ = tookMs;
    if (!picture_) picture_.host = std::make_shared<const Image<Rgba8>>(toScreen(*image_, job.background, job.uncovered));
  }

  void drawToHost(const WarpJob& job, const std::stop_token& stop) {
    if (isInHostMemory_) return;
    if (isHandedOut_) image_ = std::make_shared<WarpedImage>();  // somebody may still look at the last
    isHandedOut_ = false;
    warp_->draw(job.camera, job.settings, *image_, stop);
    isInHostMemory_ = true;
  }

  std::shared_ptr<const WarpedImage> imageToJudge(const WarpJob& job, bool isOtherReference, const std::stop_token& stop) {
    if (job.reference->job().camera == job.camera) {
      drawToHost(job, stop);
      isHandedOut_ = true;
      return image_;
    }
    if (!isOtherReference) return nullptr;
    auto image = std::make_shared<WarpedImage>();
    warp_->draw(job.reference->job().camera, job.settings, *image, stop);
    return image;
  }

  const gl::Platform platform_;
  WarpResources resources_;
  std::unique_ptr<gl::Context> context_;  // outlives the warp, whose objects are in it
  std::unique_ptr<Warp> warp_;
  WarpJob last_;
  std::shared_ptr<WarpedImage> image_ = std::make_shared<WarpedImage>();
  bool isDrawn_ = false;         // since the last result
  bool isInHostMemory_ = false;  // image_ is what picture_ shows
  bool isHandedOut_ = false;     // image_ is in a result, and must stay as it is
  std::shared_ptr<const ReferenceImage> reference_;  // of the last job
  ShownPicture picture_;
  double buildMs_ = 0.0;
  double drawMs_ = 0.0;
  FrameCodec codec_;
  RecentNeed need_;  // of samples and pixels
};

void marchReference(const ReferenceJob& job, ReferenceResult& result, const std::stop_token& stop) {
  result.job = job;
  Image<glm::vec4> color;
  job.marcher->render(job.camera, job.settings, color, stop);
  auto image = std::make_shared<const ReferenceImage>(job, std::move(color));
  if (job.marcher->capabilities().judging == JudgePlace::host)
    image->judge();  // here, and not in each panel's thread; a device has its own judges
  result.image = std::move(image);
}

}  // namespace

const PictureJudge& ReferenceImage::judge() const {
  std::call_once(isPrepared_, [this] { judge_.emplace(color_, job_.background); });
  return *judge_;
}

std::unique_ptr<WarpWorker> makeWarpWorker(gl::Platform platform, WarpResources resources, std::function<void()> onResult) {
  return std::make_unique<WarpWorker>(
      [platform, resources]() -> WarpWorker::Work {
        auto easel = std::make_shared<Easel>(platform, resources);
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
