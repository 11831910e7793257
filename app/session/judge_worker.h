// A panel's judge: what its picture differs by from the ground truth, in figures and pixel by pixel.
// In a thread of its own, because it takes longer than a picture does: what it is at work on never delays the next picture.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "app/experiment/configuration.h"
#include "app/session/panel_content.h"
#include "app/session/warp_worker.h"
#include "render/base/newest_worker.h"

namespace warpscope {

struct JudgeJob {
  WarpResult drawn;                            ///< with `judged` and its job's `reference`; without: there is nothing to judge, and what was kept to judge by goes
  std::optional<Configuration> configuration;  ///< that drew it, if it is known
  PictureContent content = PictureContent::picture;  ///< that is to be found besides
  std::optional<float> contentRange;                 ///< of its ramp
};

struct Judgement {
  JudgeJob job;            ///< that was done
  PictureErrors errors;
  PanelContent content;    ///< that was wanted; nothing of the picture itself
  std::shared_ptr<const PanelPixels> pixels;
  std::optional<size_t> pictureBytes;  ///< pictureBytes() of the frame, where the technique needs no more of it and its configuration is known
  std::string error;
};

using JudgeWorker = NewestWorker<JudgeJob, Judgement>;

/// How pictures are judged: as PictureJudge::errorsOf does, with the map of FLIP left in the last parameter. Used from one thread.
using JudgeFunction = std::function<PictureErrors(const std::shared_ptr<const ReferenceImage>&, const WarpedImage&, Image<float>&)>;
/// Makes one for each worker and scene, on the worker's thread.
using JudgeMaker = std::function<JudgeFunction()>;

/// Judges on the CUDA device where the ground truth was marched on one, until the device fails in that scene; else on the CPU.
JudgeFunction makeJudge();

/// `crew`: that its loops run on; null: on all cores, as ever.
std::unique_ptr<JudgeWorker> makeJudgeWorker(JudgeMaker maker, std::function<void()> onResult, std::shared_ptr<Crew> crew = nullptr);

}  // namespace warpscope
