// A plan for each new kind of frame, its costs for each at rest.
// See live_plan.h.
#include "app/session/live_plan.h"

#include <utility>

#include "render/core/crew_work.h"

namespace warpscope {
namespace {

/// With and without each stage: a few seconds of a march that takes a tenth of one.
constexpr int kRuns = 3;

void planAndMeasure(const PlanJob& job, PlanResult& result, const std::stop_token& stop) {
  result.job = job;
  result.plan = job.marcher->plan(job.settings.render, job.settings.sample);
  if (job.isMeasured && result.plan)
    result.costs = measureStages(*job.marcher, job.camera, job.settings, *result.plan, kRuns, [](std::string_view) {}, stop);
}

}  // namespace

LivePlan::LivePlan(std::function<void()> onNews, std::shared_ptr<Crew> crew)
    : worker_(workOfCrew([]() -> PlanWorker::Work { return planAndMeasure; }, std::move(crew), Crew::kOfMarches), std::move(onNews)) {}

void LivePlan::clear() {
  worker_.cancel();
  wanted_ = measured_ = {};
  plan_.reset();
  costs_.reset();
  isKnown_ = isMeasuring_ = false;
  error_.clear();
}

bool LivePlan::follow(const MarcherPtr& marcher, const SampleFrame& frame) {
  PlanJob wanted{marcher, frame.camera, frame.settings};
  if (wanted == wanted_) return false;
  const bool isSamePlan = wanted.marcher == wanted_.marcher && wanted.settings == wanted_.settings;
  wanted_ = std::move(wanted);
  if (isMeasuring_) measure(false);
  if (isSamePlan) return true;
  isKnown_ = false;
  costs_.reset();
  worker_.cancel();
  worker_.post(wanted_);  // the plan on show stays until there is another
  return true;
}

void LivePlan::measure(bool mayMeasure) {
  const bool wants = mayMeasure && isKnown_ && plan_ && error_.empty() && !areCurrent();
  if (wants == isMeasuring_) return;
  isMeasuring_ = wants;
  if (!wants) return worker_.cancel();
  PlanJob job = wanted_;
  job.isMeasured = true;
  worker_.post(std::move(job));
}

bool LivePlan::take() {
  std::optional<PlanResult> result = worker_.tryTake();
  if (!result) return false;
  const bool isMeasured = std::exchange(result->job.isMeasured, false);
  const bool isOfUse = result->job.marcher == wanted_.marcher && result->job.settings == wanted_.settings;
  if (!isOfUse || (isMeasured && !isMeasuring_)) return false;
  error_ = std::move(result->error);
  plan_ = std::move(result->plan);
  isKnown_ = true;
  if (!isMeasured) return true;
  isMeasuring_ = false;
  costs_ = std::move(result->costs);
  measured_ = std::move(result->job);
  return true;
}

}  // namespace warpscope
