// Ground truths first, then technique by technique.
// See fair_measuring.h.
#include "app/session/fair_measuring.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "app/experiment/findings.h"
#include "app/experiment/measuring.h"
#include "app/frames/backend.h"
#include "app/session/own_context.h"
#include "render/core/crew_work.h"
#include "render/metrics/picture_errors.h"

namespace warpscope {
namespace {

constexpr int kRuns = 3;

View turned(View view, double degrees) {
  view.angleDeg = std::remainder(view.angleDeg + degrees, 360.0);
  return view;
}

/// On the worker's thread, whose context it keeps.
class FairWork {
 public:
  FairWork(gl::Platform platform, WarpResources resources) : resources_(std::move(resources)) { resources_.context = makeOwnContext(platform); }

  void operator()(const FairJob& job, FairResult& result, const std::stop_token& stop) {
    std::vector<Camera> cameras;
    std::vector<std::unique_ptr<PictureJudge>> judges;
    for (const double angle : kFairAnglesDeg) {
      cameras.push_back(makeCamera(*job.scene, turned(job.frameView, angle), job.sizePx.x, job.sizePx.y));
      Image<glm::vec4> truth;
      job.marcher->render(cameras.back(), job.reference, truth, stop);
      judges.push_back(std::make_unique<PictureJudge>(truth, job.scene->background));
      ++*job.done;
    }
    WarpResources resources = resources_;  // with its context, and with what is the job's only
    resources.marcher = job.marcher;
    FrameCodec codec(makeTiledCoder(resources.backend));
    for (const Configuration& configuration : job.configurations) {
      const std::unique_ptr<Warp> warp = makeWarp(*configuration.technique, resources);
      WarpSettings settings = configuration.warp({});
      settings.reference = job.reference;
      FairPoint point{.configuration = configuration, .angles = {}, .pictureSize = job.sizePx};
      for (size_t i = 0; i < cameras.size(); ++i) {
        const MeasuredPicture picture = measurePicture(Measuring(kRuns, stop), {*warp, settings, job.scene->background, placeFor(*configuration.technique)}, codec, configuration.codec, job.frame, cameras[i]);
        WarpedImage image;
        warp->draw(cameras[i], settings, image, stop);
        point.angles.push_back({kFairAnglesDeg[i], picture.frameMs(), judges[i]->errorsOf(image).flip});
        point.frameMs = std::max(point.frameMs, point.angles.back().frameMs);
        point.flip += point.angles.back().flip / static_cast<double>(cameras.size());
        ++*job.done;
      }
      result.points.push_back(std::move(point));
    }
  }

 private:
  WarpResources resources_;
};

std::vector<size_t> frontOf(const std::vector<FairPoint>& points) {
  std::vector<CostAndError> figures;
  for (const FairPoint& point : points) figures.push_back({point.frameMs, point.flip});
  return paretoFront(figures);
}

}  // namespace

FairMeasuring::FairMeasuring(gl::Platform platform, WarpResources resources, std::function<void()> onNews, std::shared_ptr<Crew> crew)
    : worker_(workOfCrew([platform, resources = std::move(resources)]() -> FairWorker::Work { return FairWork(platform, resources); }, std::move(crew), Crew::kOfPictures),
              std::move(onNews)) {}

void FairMeasuring::start(FairJob job) {
  cancel();
  done_ = job.done = std::make_shared<std::atomic<size_t>>(0);
  steps_ = kFairAnglesDeg.size() * (1 + job.configurations.size());
  error_.clear();
  worker_.post(std::move(job));
}

void FairMeasuring::cancel() {
  worker_.cancel();
  static_cast<void>(worker_.tryTake());
  steps_ = 0;
}

void FairMeasuring::clear() {
  cancel();
  points_.clear();
  front_.clear();
  error_.clear();
}

bool FairMeasuring::take() {
  std::optional<FairResult> result = worker_.tryTake();
  if (!result || steps_ == 0) return false;
  steps_ = 0;
  error_ = std::move(result->error);
  if (!error_.empty()) return true;
  points_ = std::move(result->points);
  front_ = frontOf(points_);
  return true;
}

}  // namespace warpscope
