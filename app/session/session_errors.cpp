// The part of a session that finds out how wrong its pictures are and what they take: the ground truth, its judges, times, and what is kept of them.
// See session.h.
#include "app/experiment/auto_choice.h"
#include "app/session/session.h"

namespace warpscope {
namespace {

/// How long the camera must rest before the ground truth is marched.
constexpr std::chrono::milliseconds kRest(150);
/// Where it follows the moving camera: how often. Each costs the panels a drawing, and the CPU what judging takes.
constexpr std::chrono::milliseconds kLivePeriod(200);
/// How long nothing must have happened before a picture is timed: the window, too, has drawn itself for the last time by then.
constexpr std::chrono::milliseconds kQuiet(600);

/// Whether a picture of one is worth comparing with a ground truth of the other: nothing but the camera's place differs.
bool differOnlyInPlace(const ReferenceJob& a, const ReferenceJob& b) {
  ReferenceJob moved = a;
  moved.camera = b.camera;
  return moved == b && a.camera.width == b.camera.width && a.camera.height == b.camera.height;
}

glm::uvec2 sizeOf(const Camera& camera) { return {camera.width, camera.height}; }

}  // namespace

ReferenceJob Session::wantedReference() const {
  return {loaded_->display, cameraOfSize(pictureSize()), knobs_.march.render, loaded_->scene.background};
}

bool Session::askReference(TimePoint now) {
  ReferenceJob wanted = wantedReference();
  if (wanted != referenceWanted_) {
    const bool goesOn = isReferenceLive() && differOnlyInPlace(referenceWanted_, wanted);
    referenceWanted_ = std::move(wanted);
    movedAt_ = now;
    if (!goesOn) {
      referenceAsked_ = {};
      reference_.reset();
      referenceWorker_->cancel();
    }
  }
  if (referenceAsked_ == referenceWanted_) return false;
  const bool isTime = isReferenceLive() ? now - referenceAskedAt_ >= kLivePeriod : now - movedAt_ >= kRest;
  if (!isTime) return true;  // the time passes without further events
  referenceAsked_ = referenceWanted_;
  referenceAskedAt_ = now;
  referenceWorker_->post(referenceAsked_);
  return true;
}

bool Session::takeReference() {
  std::optional<ReferenceResult> result = referenceWorker_->tryTake();
  if (!result) return false;
  const bool isWanted = result->job == referenceAsked_ || (isReferenceLive() && differOnlyInPlace(result->job, referenceWanted_));
  if (!isWanted) return false;
  referenceError_ = std::move(result->error);
  if (result->image) reference_ = std::move(result->image);
  return true;
}

std::optional<Configuration> Session::configurationOf(const WarpJob& drawn) const {
  const auto asked = drawn.frame ? askedFor_.find(drawn.frame->requestId) : askedFor_.end();
  if (asked == askedFor_.end()) return std::nullopt;
  Configuration configuration;
  configuration.technique = drawn.technique;
  configuration.march = asked->second.march;
  configuration.serverSidePx = asked->second.serverSidePx;
  configuration.codec = asked->second.codec;
  configuration.knobs = drawn.settings.knobs;
  return normalized(configuration);
}

void Session::judge(size_t index, WarpResult drawn) {
  if (!drawn.judged) return;
  judgeWorkers_[index]->post({std::move(drawn), panels_[index].configuration});
}

bool Session::isJudged(const Panel& panel, const JudgeJob& job) const {
  return job.drawn.job.technique == panel.technique && job.drawn.job.reference->job() == referenceWanted_ && job.drawn.picture == panel.picture;
}

bool Session::areCurrent(const Panel& panel, const JudgeJob& job, TimePoint judgedAt, TimePoint now) const {
  const WarpJob& drawn = job.drawn.job;
  if (isJudged(panel, job)) return true;
  if (drawn.technique != panel.technique) return false;
  return isReferenceLive() && differOnlyInPlace(drawn.reference->job(), referenceWanted_) && now - judgedAt < kLiveErrors;
}

bool Session::takeErrors(size_t index, TimePoint now) {
  Panel& panel = panels_[index];
  const bool wereCurrent = panel.errorsAreCurrent;
  std::optional<Judgement> judgement = judgeWorkers_[index]->tryTake();
  const bool isNew = judgement && areCurrent(panel, judgement->job, now, now);
  if (isNew && !judgement->error.empty()) {
    referenceError_ = std::move(judgement->error);
  } else if (isNew) {
    panel.errors = judgement->errors;
    panel.heatMap = std::move(judgement->heatMap);
    panel.history.add(now, panel.errors->flip);
    const WarpJob& drawn = judgement->job.drawn.job;
    if (judgement->job.configuration)
      liveFront_.addError(*judgement->job.configuration, sizeOf(drawn.reference->job().camera),
                          angleBetweenDeg(drawn.frame->camera, drawn.reference->job().camera), panel.errors->flip);
    judged_[index] = Judged{std::move(judgement->job), now};
  }
  panel.errorsAreCurrent = judged_[index] && areCurrent(panel, judged_[index]->job, judged_[index]->at, now);
  if (wereCurrent && !panel.errorsAreCurrent) panel.history.interrupt(now);
  return isNew || wereCurrent != panel.errorsAreCurrent;
}

bool Session::isAtRest() const {
  const bool isServerAtRest = !isServerAtWork() && (wanted_ == asked_ || knobs_.isFrozen);
  if (!loading_.empty() || !isServerAtRest || referenceAsked_ != referenceWanted_) return false;
  for (size_t i = 0; i < kPanelCount; ++i) {
    const bool isDone = !panels_[i].error.empty() || (judged_[i] && isJudged(panels_[i], judged_[i]->job));
    if (isDrawing_[i] || !isDone) return false;
  }
  return true;
}

void Session::timePictures(TimePoint now) {
  if (!isAtRest()) {
    quietSince_ = now;
    stopTiming();
  }
  for (size_t i = 0; i < kPanelCount && !timing_ && now - quietSince_ >= kQuiet; ++i) {
    const Panel& panel = panels_[i];
    if (!panel.configuration || !panel.error.empty() || timed_[i] == panel.picture) continue;
    WarpJob job = jobs_[i];
    job.timedAs = panel.configuration->codec;
    timing_ = i;
    warpWorkers_[i]->post(std::move(job));
  }
}

void Session::takeTime(size_t index, const WarpResult& result) {
  if (timing_ != index) return;  // it was stopped too late
  timing_.reset();
  const Panel& panel = panels_[index];
  timed_[index] = panel.picture;  // also where it failed: it would again
  if (!result.timed || !panel.configuration) return;
  const WarpJob& job = result.job;
  liveFront_.addTime(*panel.configuration, sizeOf(job.camera), angleBetweenDeg(job.frame->camera, job.camera), result.timed->frameMs());
}

void Session::stopTiming() {
  if (timing_) warpWorkers_[*timing_]->cancel();
  timing_.reset();
}

void Session::choose(size_t panel, const Configuration& configuration) {
  const WarpDescriptor& technique = *configuration.technique;
  setTechnique(panel, technique);
  knobs_.march.render = configuration.march.render;
  takeOver(configuration, knobs_.march, knobs_.warp);
  if (!technique.usesFrame) return;
  knobs_.serverSidePx = configuration.serverSidePx;
  knobs_.transport.codec = configuration.codec;
}

}  // namespace warpscope
