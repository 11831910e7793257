// A panel's judge: what its picture differs by from the ground truth, in figures and pixel by pixel.
// In a thread of its own, because it takes longer than a picture does: what it is at work on never delays the next picture.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "app/newest_worker.h"
#include "app/sweep/configuration.h"
#include "app/warp_worker.h"

namespace warpscope {

struct JudgeJob {
  WarpResult drawn;                            ///< with `judged` and its job's `reference`
  std::optional<Configuration> configuration;  ///< that drew it, if it is known
};

struct Judgement {
  JudgeJob job;            ///< that was done
  PictureErrors errors;
  ShownPicture heatMap;    ///< FLIP for each pixel, see heat_map.h; of the size of what was judged
  std::string error;
};

using JudgeWorker = NewestWorker<JudgeJob, Judgement>;

/// How pictures are judged: as PictureJudge::errorsOf does, with the map of FLIP left in the last parameter.
using JudgeFunction = std::function<PictureErrors(const PictureJudge&, const WarpedImage&, Image<float>&)>;
PictureErrors judgeWhole(const PictureJudge& judge, const WarpedImage& image, Image<float>& map);

std::unique_ptr<JudgeWorker> makeJudgeWorker(JudgeFunction judge, std::function<void()> onResult);

}  // namespace warpscope
