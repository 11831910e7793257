// One tracer, kept as long as the volume and its transfer function are the same.
// See live_ray.h.
#include "app/session/live_ray.h"

#include <utility>

namespace warpscope {
namespace {

class RayWork {
 public:
  void operator()(const RayJob& job, RayResult& result, const std::stop_token& stop) {
    result.job = job;
    if (!tracer_ || job.volume != volume_ || job.transferFunction != transferFunction_) {
      tracer_.reset();
      tracer_ = makeRayTracer(job.volume, job.transferFunction);
      volume_ = job.volume;
      transferFunction_ = job.transferFunction;
    }
    result.trace = tracer_->trace(job.ray.camera, job.settings, job.ray.pixel, stop);
    const std::optional<float> depth = job.frame ? depthBy(result.trace, job.settings.sample.heuristic) : std::nullopt;
    if (depth) result.seen = seenByFrame(*job.frame, result.trace.ray.at(*depth));
  }

 private:
  std::shared_ptr<RayTracer> tracer_;  // shared, because functions are copied
  VolumePtr volume_;
  TransferFunction transferFunction_;
};

}  // namespace

LiveRay::LiveRay(std::function<void()> onNews) : worker_([]() -> RayWorker::Work { return RayWork(); }, std::move(onNews)) {}

void LiveRay::clear() {
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
  if (!result || !wanted_) return false;
  if (!result->error.empty())
    error_ = std::move(result->error);
  else
    result_ = std::move(result);
  return true;
}

}  // namespace warpscope
