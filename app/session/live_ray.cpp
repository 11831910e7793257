// One tracer, kept as long as the volume and its transfer function are the same.
// See live_ray.h.
#include "app/session/live_ray.h"

#include <cmath>
#include <utility>

#include "render/core/crew_work.h"
#include "render/march/ray_trace.h"

namespace warpscope {
namespace {

class RayWork {
 public:
  /// A job without a volume: forgets the one that it has.
  void operator()(const RayJob& job, RayResult& result, const std::stop_token& stop) {
    if (!job.volume) {
      *this = {};
      return;
    }
    result.job = job;
    if (!tracer_ || job.volume != volume_ || job.transferFunction != transferFunction_) {
      tracer_.reset();
      requireWholeRays(*job.volume);  // before all of it is looked through
      tracer_ = makeRayTracer(job.volume, job.transferFunction);
      volume_ = job.volume;
      transferFunction_ = job.transferFunction;
    }
    result.trace = tracer_->trace(job.ray.camera, job.settings, job.ray.pixel, stop);
    if (!job.frame) return;
    if (job.own) {
      result.missed = missedBy(job, stop);
      return;
    }
    if (const std::optional<float> depth = depthBy(result.trace, job.settings.sample.heuristic)) result.seen = seenByFrame(*job.frame, result.trace.ray.at(*depth));
  }

 private:
  /// Of the picture's own ray: what lies on it, away from the sample by more than both are thick.
  std::optional<MissedPlace> missedBy(const RayJob& job, const std::stop_token& stop) const {
    const Sphere shown = unpackSample(job.frame->samples[*job.ray.sample], job.frame->grid());
    const RayTrace own = tracer_->trace(job.own->camera, job.settings, job.own->pixel, stop);
    const std::optional<float> depth = depthBy(own, job.settings.sample.heuristic);
    if (!depth) return std::nullopt;
    const glm::vec3 place = own.ray.at(*depth);
    const float fromEye = glm::length(place - job.own->camera.eye), before = glm::length(shown.center - job.own->camera.eye) - fromEye;
    const SeenByFrame seen = seenByFrame(*job.frame, place);
    if (std::abs(before) <= 2.0f * kLightReach + shown.radius + seen.radius) return std::nullopt;
    return MissedPlace{fromEye, before, seen};
  }

  std::shared_ptr<RayTracer> tracer_;  // shared, because functions are copied
  VolumePtr volume_;
  TransferFunction transferFunction_;
};

}  // namespace

LiveRay::LiveRay(std::function<void()> onNews, std::shared_ptr<Crew> crew)
    : worker_(workOfCrew([]() -> RayWorker::Work { return RayWork(); }, std::move(crew), Crew::kOfMarches), std::move(onNews)) {}

void LiveRay::clear() {
  lookAway();
  worker_.forget();
}

void LiveRay::lookAway() {
  worker_.cancel();
  wanted_.reset();
  result_.reset();
  error_.clear();
}

bool LiveRay::follow(RayJob wanted) {
  if (wanted_ == wanted) return false;
  wanted_ = std::move(wanted);
  error_.clear();
  if (wanted_->volume)
    worker_.post(*wanted_);
  else
    error_ = "the volume is on the server: rays can be looked at where it is";
  return true;
}

bool LiveRay::take() {
  std::optional<RayResult> result = worker_.tryTake();
  if (!result || !wanted_ || !wanted_->volume) return false;
  if (result->error.empty()) {
    error_.clear();
    result_ = std::move(result);
  } else if (result->job.ray == wanted_->ray) {  // what is said of another is followed by what is wanted
    error_ = std::move(result->error);
  }
  return true;
}

}  // namespace warpscope
