// Drawing only what changed since the last job, as the plan says.
// See warp_worker.h.
#include "app/session/warp_worker.h"

#include <chrono>
#include <utility>

#include "app/frames/backend.h"
#include "app/picture/picture.h"
#include "app/session/moving_errors.h"
#include "app/session/own_context.h"
#include "app/shell/log.h"
#include "render/base/error.h"
#include "render/base/recent_need.h"
#include "render/base/stopwatch.h"
#include "render/core/crew_work.h"
#include "render/core/expected_break.h"
#include "render/core/freed_memory.h"
#include "render/warp/rotated_picture.h"

namespace warpscope {
namespace {

/// Of a picture on show: some tenths of a second without a GPU.
constexpr int kTimedRuns = 5;

/// One technique at work, on the worker's thread.
class Easel {
 public:
  Easel(gl::Platform platform, WarpResources resources) : resources_(std::move(resources)) {
    resources_.context = makeOwnContext(platform, [](const gl::Context& made) { logDetail("OpenGL of a panel: " + std::string(made.platformName()) + ", " + made.renderer()); });
  }

  void paint(const WarpJob& job, WarpResult& result, const std::stop_token& stop) {
    if (job.technique == nullptr) {
      forget();
      giveBackFreedMemory();
      return;
    }
    result.job = job;
    if (std::exchange(countedFor_, job.scene) != job.scene) counts_ = {};
    result.counts = counts_;
    if (job.timedAs) return time(job, result, stop);
    if (isOversized(job)) {
      forget();
      giveBackFreedMemory();
    }
    result.plan = PicturePlan(state_, job);
    try {
      follow(result.plan, job, stop);
    } catch (...) {
      forget();  // the technique may be half way between two frames
      result.counts = counts_;
      throw;
    }
    result.counts = counts_;
    result.picture = picture_;
    result.buildMs = result.plan.way() == PictureWay::technique ? buildMs_ : 0.0;
    result.drawMs = drawMs_;
    result.finishedAt = std::chrono::steady_clock::now();
    if (result.plan.has(PictureStage::judge)) result.judged = imageToJudge(job, stop);
    if (!result.judged && isInHostMemory_)
      result.sparse = std::make_shared<const WarpedImage>(sparseImage(*image_, sparsePixels({job.camera.width, job.camera.height}, MovingErrors::kPixels)));
    state_.reference = job.reference;
    result.counts = counts_;
  }

 private:
  /// Does again what the last picture took, nothing of which is shown.
  void time(const WarpJob& job, WarpResult& result, const std::stop_token& stop) {
    const bool isLast = warp_ && state_.hasPicture && state_.way == PictureWay::technique &&
                        job.technique == state_.technique && job.frame == state_.frame && job.camera == state_.camera &&
                        job.settings == state_.settings;
    if (!isLast) return;
    try {
      result.timed = measurePicture(Measuring::inWholeRuns(kTimedRuns, stop), {*warp_, job.settings, job.background, placeFor(*job.technique)}, codec_, *job.timedAs, job.frame,
                                    job.camera);
    } catch (const OperationCancelled&) {
      throw;  // between two runs: the technique is whole
    } catch (...) {
      forgetTechnique();
      throw;
    }
  }

  /// OpenGL's threads do not pause, once they draw. `lastMs`: what the like took the last time.
  static void leaveBreakAlone(const WarpJob& job, double lastMs) {
    if (job.technique->usesOpenGl) warpscope::leaveBreakAlone(std::chrono::duration<double, std::milli>(lastMs));
  }

  /// Whether what techniques and pictures keep for a frame as large as some earlier one is to go.
  bool isOversized(const WarpJob& job) {
    if (!job.frame || job.frame == state_.frame) return false;
    return need_.exceedsRecent(job.frame->size() + size_t{job.camera.width} * job.camera.height);
  }

  void forgetTechnique() {
    warp_.reset();
    resources_.marcher.reset();
    state_.technique = nullptr;
    state_.scene = 0;
    state_.marcher.reset();
    state_.isBuilt = false;
    state_.built.reset();
  }

  void forget() {
    forgetTechnique();
    state_ = {};
    picture_ = {};
    own_.reset();
    image_ = std::make_shared<WarpedImage>();
    isHandedOut_ = isInHostMemory_ = false;
  }

  void follow(const PicturePlan& plan, const WarpJob& job, const std::stop_token& stop) {
    // What is not the job's only holds memory, whether or not another one is made in its place.
    if (state_.technique != job.technique || state_.scene != job.scene || (state_.marcher != job.marcher && !job.technique->usesFrame)) forgetTechnique();
    resources_.marcher = state_.marcher = job.marcher;  // an earlier one only holds memory
    if (state_.frame != job.frame || !job.takesShortcuts) own_.reset();
    if (plan.has(PictureStage::technique)) make(job);
    if (plan.has(PictureStage::build)) build(job, stop);
    if (plan.has(PictureStage::toScreen)) picture_ = {};
    if (plan.has(PictureStage::draw)) draw(job, stop);
    if (plan.has(PictureStage::ownPicture) || plan.has(PictureStage::rotation)) takeShortcut(plan.way(), job, stop);
    if (plan.has(PictureStage::toScreen) && !picture_)
      picture_.host = std::make_shared<const Image<Rgba8>>(toScreen(*image_, job.background, job.marks));

    state_.hasPicture = true;
    state_.way = plan.way();
    state_.frame = job.frame;
    state_.camera = job.camera;
    state_.settings = job.settings;
    state_.background = job.background;
    state_.marks = job.marks;
    state_.isOnDevice = picture_.device != nullptr;
  }

  void make(const WarpJob& job) {
    ++counts_.made;
    resources_.marcher = job.marcher;
    warp_ = makeWarp(*job.technique, resources_);
    state_.technique = job.technique;
    state_.scene = job.scene;
    state_.marcher = job.marcher;
  }

  void build(const WarpJob& job, const std::stop_token& stop) {
    ++counts_.builds;
    leaveBreakAlone(job, buildMs_);
    buildMs_ = milliseconds([&] { warp_->setFrame(job.frame, job.settings, stop); });
    state_.isBuilt = true;
    state_.built = job.frame;
    state_.builtWith = job.settings.knobs;
  }

  void draw(const WarpJob& job, const std::stop_token& stop) {
    ++counts_.draws;
    isInHostMemory_ = false;
    leaveBreakAlone(job, drawMs_);
    drawMs_ = milliseconds([&] {
      picture_.device = warp_->drawForScreen(job.camera, job.settings, job.background, job.marks, stop);
      if (!picture_) drawToHost(job, stop);
    });
  }

  void drawToHost(const WarpJob& job, const std::stop_token& stop) {
    warp_->draw(job.camera, job.settings, newImage(), stop);
    isInHostMemory_ = true;
  }

  void takeShortcut(PictureWay way, const WarpJob& job, const std::stop_token& stop) {
    ++counts_.shortcuts;
    isInHostMemory_ = false;
    drawMs_ = milliseconds([&] {
      if (!own_) own_ = std::make_shared<WarpedImage>(ownImageOf(*onHost(job.frame)));
      if (way == PictureWay::rotation) {
        drawRotated(*own_, job.frame->camera, job.camera, newImage(), stop);
      } else {
        image_ = own_;
        isHandedOut_ = true;  // it stays as it is, to be turned
      }
    });
    isInHostMemory_ = true;
  }

  /// To be drawn to. Somebody may still look at the last.
  WarpedImage& newImage() {
    if (std::exchange(isHandedOut_, false)) image_ = std::make_shared<WarpedImage>();
    return *image_;
  }

  std::shared_ptr<const WarpedImage> imageToJudge(const WarpJob& job, const std::stop_token& stop) {
    if (job.reference->job().camera == job.camera) {
      if (!isInHostMemory_) {
        ++counts_.drawsToJudge;
        drawToHost(job, stop);
      }
      isHandedOut_ = true;
      return image_;
    }
    ++counts_.drawsToJudge;
    auto image = std::make_shared<WarpedImage>();
    warp_->draw(job.reference->job().camera, job.settings, *image, stop);
    return image;
  }

  WarpResources resources_;  // whose context outlives the warp, which has objects in it
  std::unique_ptr<Warp> warp_;
  EaselState state_;
  std::shared_ptr<WarpedImage> image_ = std::make_shared<WarpedImage>();
  bool isInHostMemory_ = false;  // image_ is what picture_ shows
  bool isHandedOut_ = false;     // image_ is in a result, or own_, and must stay as it is
  std::shared_ptr<WarpedImage> own_;  // of the state's frame; null until a shortcut wants it
  ShownPicture picture_;
  double buildMs_ = 0.0;
  double drawMs_ = 0.0;
  WarpCounts counts_;
  uint64_t countedFor_ = 0;
  FrameCodec codec_{makeTiledCoder(resources_.backend)};
  RecentNeed need_;  // of samples and pixels
};

void marchReference(const ReferenceJob& job, ReferenceResult& result, const std::stop_token& stop) {
  if (!job.marcher) return;  // nothing is kept
  result.job = job;
  Image<glm::vec4> color;
  job.marcher->render(job.camera, job.settings, color, stop);
  auto image = std::make_shared<const ReferenceImage>(job, std::move(color));
  if (job.marcher->capabilities().judging == JudgePlace::host)
    image->judge();  // here, and not in each panel's thread; a device has its own judges
  result.image = std::move(image);
}

}  // namespace

ReferenceImage::ReferenceImage(ReferenceJob job, Image<glm::vec4> color)
    : job_(std::move(job)), color_(std::move(color)), picture_(std::make_shared<const Image<Rgba8>>(toScreen(color_, job_.background))) {}

const PictureJudge& ReferenceImage::judge() const {
  std::call_once(isPrepared_, [this] { judge_.emplace(color_, job_.background); });
  return *judge_;
}

std::unique_ptr<WarpWorker> makeWarpWorker(gl::Platform platform, WarpResources resources, std::function<void()> onResult, std::shared_ptr<Crew> crew) {
  const auto makeWork = [platform, resources]() -> WarpWorker::Work {
    return [easel = std::make_shared<Easel>(platform, resources)](const WarpJob& job, WarpResult& result, const std::stop_token& stop) { easel->paint(job, result, stop); };
  };
  return std::make_unique<WarpWorker>(workOfCrew(makeWork, std::move(crew), Crew::kOfPictures), std::move(onResult));
}

std::unique_ptr<ReferenceWorker> makeReferenceWorker(std::function<void()> onResult, std::shared_ptr<Crew> crew) {
  return std::make_unique<ReferenceWorker>(workOfCrew([]() -> ReferenceWorker::Work { return marchReference; }, std::move(crew), Crew::kOfMarches), std::move(onResult));
}

}  // namespace warpscope
