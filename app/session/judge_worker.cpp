// Judging what a panel drew.
// See judge_worker.h.
#include "app/session/judge_worker.h"

#include "app/frames/frame_fetch.h"
#include "app/shell/log.h"
#include "render/base/error.h"
#include "render/core/crew_work.h"
#include "render/metrics/holes.h"
#include "render/metrics/picture_judge_cuda.h"

namespace warpscope {
namespace {

/// A device's judge with the ground truth that it holds.
class DeviceJudge {
 public:
  PictureErrors errorsOf(const std::shared_ptr<const ReferenceImage>& reference, const WarpedImage& image, Image<float>& map) {
    const glm::vec3& background = reference->job().background;
    if (!judge_ || background != background_) {
      judge_ = makeCudaPictureJudge(background);
      background_ = background;
      reference_.reset();
    }
    if (reference != reference_) {
      reference_.reset();
      judge_->setReference(reference->color());
      reference_ = reference;
    }
    const DeviceErrors found = judge_->errorsOf(image.color, &map);
    PictureErrors errors;
    errors.psnrDb = found.psnrDb;
    errors.psnrLinearDb = found.psnrLinearDb;
    errors.ssim = found.ssim;
    errors.flip = found.flip;
    const HoleCount holes = countHoles(image, reference->color());
    errors.holeFraction = holes.fraction();
    errors.filledFraction = holes.filledFraction();
    return errors;
  }

 private:
  std::unique_ptr<DevicePictureJudge> judge_;
  glm::vec3 background_{0.0f};
  std::shared_ptr<const ReferenceImage> reference_;
};

/// What the picture of the last frame takes; it is coded once.
class PictureOfFrame {
 public:
  size_t bytes(const SampleFramePtr& frame, const glm::vec3& background, const CodecSettings& codec) {
    if (frame != frame_ || background != background_ || !(codec == codec_)) bytes_ = pictureBytes(frame, background, codec);
    frame_ = frame;
    background_ = background;
    codec_ = codec;
    return bytes_;
  }

 private:
  SampleFramePtr frame_;
  glm::vec3 background_{0.0f};
  CodecSettings codec_;
  size_t bytes_ = 0;
};

/// What is known of the pixels of the job's picture.
std::shared_ptr<const PanelPixels> pixelsOf(const WarpResult& drawn, PictureContent content, Image<float> flip, const std::stop_token& stop) {
  const WarpJob& job = drawn.job;
  const Camera& camera = job.reference->job().camera;
  const bool isShown = camera == job.camera;
  // Of a view that passes nobody looks at pixels.
  const SampleFramePtr frame = isShown || content != PictureContent::picture ? onHost(job.frame) : job.frame;
  PanelPixels pixels{isShown ? drawn.picture : ShownPicture{}, drawn.judged, job.reference, frame, job.background, job.marks, std::move(flip), std::nullopt};
  if (isShown && drawn.plan.way() == PictureWay::technique) pixels.segments = segmentLookOf(*job.technique, pixels.frame.get(), camera, stop);
  return std::make_shared<const PanelPixels>(std::move(pixels));
}

/// What the job's content is of its picture.
PanelContent contentOf(const JudgeJob& job, const PanelPixels& pixels) {
  PanelContent found;
  found.what = job.content;
  found.range = job.contentRange;
  if (job.content == PictureContent::picture) return found;
  try {
    ShownContent content = show(job.content, pixels.inputs(), job.contentRange);
    found.picture.host = std::make_shared<const Image<Rgba8>>(std::move(content.picture));
    found.hasRamp = content.hasRamp;
    found.low = content.low;
    found.high = content.high;
  } catch (const InputError& error) {
    found.refusal = error.what();
  }
  return found;
}

}  // namespace

JudgeFunction makeJudge() {
  return [device = std::make_shared<DeviceJudge>(), hasFailed = false](const std::shared_ptr<const ReferenceImage>& reference, const WarpedImage& image,
                                                                       Image<float>& map) mutable {
    if (!hasFailed && reference->job().marcher->capabilities().judging == JudgePlace::cudaDevice) {
      try {
        return device->errorsOf(reference, image, map);
      } catch (const DeviceError& error) {
        hasFailed = true;
        device.reset();
        logDetail(std::string("pictures are judged on the CPU: ") + error.what());
      }
    }
    return reference->judge().errorsOf(image, nullptr, &map);
  };
}

std::unique_ptr<JudgeWorker> makeJudgeWorker(JudgeMaker maker, std::function<void()> onResult, std::shared_ptr<Crew> crew) {
  const auto makeWork = [maker = std::move(maker)]() -> JudgeWorker::Work {
    return [maker, judge = JudgeFunction(), picture = PictureOfFrame{}](const JudgeJob& job, Judgement& judgement, const std::stop_token& stop) mutable {
      if (!job.drawn.judged) {
        judge = nullptr;
        picture = {};
        return;
      }
      if (!judge) judge = maker();
      judgement.job = job;
      Image<float> map;
      judgement.errors = judge(job.drawn.job.reference, *job.drawn.judged, map);
      judgement.pixels = pixelsOf(job.drawn, job.content, std::move(map), stop);
      judgement.content = contentOf(job, *judgement.pixels);
      if (drawsPictureAlone(*job.drawn.job.technique) && job.configuration)
        judgement.pictureBytes = picture.bytes(job.drawn.job.frame, job.drawn.job.background, job.configuration->codec);
    };
  };
  return std::make_unique<JudgeWorker>(workOfCrew(makeWork, std::move(crew), Crew::kOfMarches), std::move(onResult));
}

}  // namespace warpscope
