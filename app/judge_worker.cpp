// Judging what a panel drew.
// See judge_worker.h.
#include "app/judge_worker.h"

#include "app/heat_map.h"

namespace warpscope {

PictureErrors judgeWhole(const PictureJudge& judge, const WarpedImage& image, Image<float>& map) { return judge.errorsOf(image, nullptr, &map); }

std::unique_ptr<JudgeWorker> makeJudgeWorker(JudgeFunction judge, std::function<void()> onResult) {
  return std::make_unique<JudgeWorker>(
      [judge = std::move(judge)]() -> JudgeWorker::Work {
        return [judge](const JudgeJob& job, Judgement& judgement, const std::stop_token&) {
          judgement.job = job;
          Image<float> map;
          judgement.errors = judge(job.drawn.job.reference->judge, *job.drawn.judged, map);
          judgement.heatMap.host = std::make_shared<const Image<Rgba8>>(heatMap(map, kHeatGain));
        };
      },
      std::move(onResult));
}

}  // namespace warpscope
