// What comes back from a panel's threads, and whether it is still true.
// See live_panel.h.
#include "app/session/live_panel.h"

#include <utility>

#include "app/experiment/auto_choice.h"
#include "app/frames/frame_fetch.h"
#include "render/warp/fill.h"

namespace warpscope {

LivePanel::LivePanel(uint64_t id, const PanelSettings& settings, std::unique_ptr<WarpWorker> warp, std::unique_ptr<JudgeWorker> judge)
    : warp_(std::move(warp)), judge_(std::move(judge)) {
  static_cast<PanelSettings&>(shown_) = settings;
  shown_.id = id;
}

void LivePanel::giveCamera(const View& view, const std::function<void()>& onNews, const std::shared_ptr<Crew>& crew) {
  if (!ownCamera_) ownCamera_ = std::make_unique<OwnCamera>(OwnCamera{{}, LiveGroundTruth(onNews, crew)});
  ownCamera_->view.begin(view);
  hasOwnCamera_ = true;
}

void LivePanel::takeCamera() {
  hasOwnCamera_ = false;
  if (ownCamera_) ownCamera_->truth.clear();
}

void LivePanel::setChoice(std::optional<Configuration> choice, std::string text) {
  shown_.choice = std::move(choice);
  shown_.choiceText = std::move(text);
}

void LivePanel::setContent(PictureContent content, std::optional<float> range) {
  if (shown_.content == content && shown_.contentRange == range) return;
  shown_.content = content;
  shown_.contentRange = range;
  if (content == PictureContent::picture) return;
  shown_.lastContent = content;
  if (!posted_) return;
  posted_->content = content;
  posted_->contentRange = range;
  judge_->post(*posted_);
}

bool LivePanel::setTechnique(const WarpDescriptor& technique) {
  if (shown_.technique == &technique) return false;
  shown_.technique = &technique;
  shown_.errorsAreCurrent = false;
  shown_.movingErrors.reset();
  warp_->cancel();  // its picture would not be shown long
  job_ = {};
  return true;
}

void LivePanel::clear() {
  warp_->forget();  // also where the panel is hidden, and nothing else comes
  judge_->forget();
  Panel fresh;
  static_cast<PanelSettings&>(fresh) = shown_;
  fresh.id = shown_.id;
  shown_ = std::move(fresh);
  chooser_.clear();
  if (ownCamera_) ownCamera_->truth.clear();
  job_ = {};
  isDrawing_ = false;
  drawnId_ = 0;
  judged_.reset();
  posted_.reset();
  timed_ = {};
}

void LivePanel::post(WarpJob job) {
  job_ = job;
  isDrawing_ = true;
  warp_->post(std::move(job));
}

void LivePanel::show(WarpResult drawn, const std::optional<FrameRequests::Arrival>& arrival, std::optional<Configuration> configuration, std::string leftOut) {
  if (drawn.job == job_) isDrawing_ = false;
  drawnId_ = drawn.requestId();
  shown_.error = std::move(drawn.error);
  shown_.counts = drawn.counts;
  if (!drawn.picture) return;
  const bool isOther = shown_.drawn != drawn.job.technique || shown_.requestId != drawn.requestId();
  shown_.picture = drawn.picture;
  shown_.drawn = drawn.job.technique;
  shown_.requestId = drawn.requestId();
  shown_.shortcut = shortcutText(drawn.plan.way());
  shown_.plan = drawn.plan;
  shown_.leftOut = std::move(leftOut);
  shown_.lack = drawn.job.frame ? lackOf(*drawn.job.technique, drawn.job.frame->settings) : "";
  if (arrival) {
    shown_.latency = arrival->latency;
    if (!drawsPictureAlone(*drawn.job.technique))
      shown_.bytes = bytesFor(*drawn.job.technique, arrival->bytes);
    else if (isOther)
      shown_.bytes.reset();
    shown_.proxyBytes = drawsProxy(*drawn.job.technique, drawn.job.settings.knobs) ? arrival->bytes.proxy : 0;
  }
  shown_.buildMs = drawn.buildMs;
  shown_.drawMs = drawn.drawMs;
  shown_.displayMs = millisecondsBetween(drawn.finishedAt, std::chrono::steady_clock::now());
  shown_.configuration = std::move(configuration);
  if (!drawn.judged) return;
  posted_ = JudgeJob{std::move(drawn), shown_.configuration, shown_.content, shown_.contentRange};
  judge_->post(*posted_);
}

bool LivePanel::isJudged(const JudgeJob& job, const LiveGroundTruth& truth) const {
  const WarpResult& drawn = job.drawn;
  return drawn.job.technique == shown_.technique && drawn.job.reference->job() == truth.wanted() && drawn.picture == shown_.picture;
}

bool LivePanel::areCurrent(const Judged& judged, const LiveGroundTruth& truth, TimePoint now) const {
  if (isJudged(judged.job, truth)) return true;
  const WarpJob& drawn = judged.job.drawn.job;
  if (drawn.technique != shown_.technique || judged.job.drawn.plan.way() != shown_.plan.way()) return false;
  return truth.followsCamera() && differOnlyInPlace(drawn.reference->job(), truth.wanted()) && now - judged.at < kLiveErrors;
}

void LivePanel::note(const MovingErrors::Found& found, TimePoint now) {
  if (found.technique != shown_.technique || shown_.errorsAreCurrent) return;
  shown_.movingErrors = found.errors;
  movingErrorsAt_ = now;
  shown_.history.add(now, found.errors.flip, true);
}

LivePanel::ErrorNews LivePanel::takeErrors(const LiveGroundTruth& truth, TimePoint now) {
  ErrorNews news;
  const bool wereCurrent = shown_.errorsAreCurrent;
  if (std::optional<Judgement> judgement = judge_->tryTake()) {
    Judged judged{std::move(judgement->job), now};
    news.happened = areCurrent(judged, truth, now);
    if (news.happened && !judgement->error.empty()) {
      news.error = std::move(judgement->error);
    } else if (news.happened) {
      // The same picture again, for the sake of another content, has the errors that it had.
      const bool isAgain = judged_ && judged_->job.drawn.picture == judged.job.drawn.picture && judged_->job.drawn.job.reference == judged.job.drawn.job.reference;
      shown_.errors = judgement->errors;
      if (judgement->pictureBytes && judged.job.drawn.requestId() == shown_.requestId) shown_.bytes = judgement->pictureBytes;
      shown_.shownContent = std::move(judgement->content);
      shown_.pixels = std::move(judgement->pixels);
      if (!isAgain) shown_.history.add(now, shown_.errors->flip);
      const Camera& camera = judged.job.drawn.job.reference->job().camera;
      if (judged.job.configuration && !isAgain)
        news.found = NewErrors{*judged.job.configuration, {camera.width, camera.height},
                               angleBetweenDeg(judged.job.drawn.job.frame->camera, camera), shown_.errors->flip};
      judged_ = std::move(judged);
    }
  }
  shown_.errorsAreCurrent = judged_ && areCurrent(*judged_, truth, now);
  if (wereCurrent && !shown_.errorsAreCurrent) shown_.history.interrupt(now);
  if (shown_.movingErrors && (shown_.errorsAreCurrent || now - movingErrorsAt_ >= kLiveErrors)) {
    shown_.movingErrors.reset();
    if (!shown_.errorsAreCurrent) shown_.history.interrupt(now);
    news.happened = true;
  }
  news.happened |= wereCurrent != shown_.errorsAreCurrent;
  return news;
}

bool LivePanel::mayShow(uint64_t requestId) const {
  if (shown_.picture && requestId == shown_.requestId) return true;
  return job_.frame && requestId >= drawnId_ && requestId <= job_.frame->requestId;
}

bool LivePanel::isAtRest(const LiveGroundTruth& truth) const {
  if (shown_.isHidden) return true;
  if (isDrawing_) return false;
  return !shown_.error.empty() || (judged_ && isJudged(judged_->job, truth) && shown_.isContentFound());
}

bool LivePanel::wantsTime() const { return !shown_.isHidden && shown_.configuration && shown_.error.empty() && timed_ != shown_.picture; }

void LivePanel::startTiming() {
  WarpJob job = job_;
  job.timedAs = shown_.configuration->codec;
  warp_->post(std::move(job));
}

void LivePanel::requestStop() {
  warp_->requestStop();
  judge_->requestStop();
  if (ownCamera_) ownCamera_->truth.requestStop();
}

bool LivePanel::waitForEnd(std::chrono::steady_clock::time_point time) const {
  return warp_->waitForEnd(time) && judge_->waitForEnd(time) && (!ownCamera_ || ownCamera_->truth.waitForEnd(time));
}

}  // namespace warpscope
