// Handing out work and collecting it.
// See session.h.
#include "app/session/session.h"

#include <algorithm>
#include <utility>

namespace warpscope {
namespace {

/// Panels draw at most this many pixels unless the user says how many.
constexpr uint64_t kFluentPixels = 600 * 1000;

}  // namespace

Session::Session(SessionSettings settings, std::function<void()> onNews)
    : knobs_(settings.knobs),
      loader_(makeSceneLoader(onNews)),
      referenceWorker_(makeReferenceWorker(onNews)) {
  for (size_t i = 0; i < kPanelCount; ++i) {
    panels_[i].technique = settings.techniques[i];
    panels_[i].isAutomatic = settings.isAutomatic[i];
    warpWorkers_[i] = makeWarpWorker(settings.platform, settings.resources, onNews);
    judgeWorkers_[i] = makeJudgeWorker(settings.makeJudge, onNews);
  }
}

void Session::load(LoadJob job) {
  cancelLoad();
  loading_ = job.name;
  loadError_.clear();
  loader_->post(std::move(job));
}

void Session::cancelLoad() {
  loader_->cancel();
  static_cast<void>(loader_->tryTake());  // what is there already is not wanted either
  loading_.clear();
}

void Session::setTechnique(size_t panel, const WarpDescriptor& technique) {
  panels_[panel].isAutomatic = false;
  panels_[panel].choice.reset();
  choiceInputs_[panel] = {};
  panels_[panel].choiceText.clear();
  useTechnique(panel, technique);
}

void Session::useTechnique(size_t panel, const WarpDescriptor& technique) {
  if (panels_[panel].technique == &technique) return;
  panels_[panel].technique = &technique;
  panels_[panel].errorsAreCurrent = false;
  stopTiming();
  warpWorkers_[panel]->cancel();  // its picture would not be shown long
  jobs_[panel] = {};
}

void Session::resetView() {
  if (loaded_) view_ = loaded_->scene.views.front();
}

void Session::dismissErrors() {
  loadError_.clear();
  viewError_.clear();
  serverError_.clear();
  referenceError_.clear();
}

const std::string& Session::error() const {
  for (const std::string* error : {&loadError_, &viewError_, &serverError_})
    if (!error->empty()) return *error;
  return referenceError_;
}

bool Session::update(TimePoint now) {
  bool happened = takeScene();
  if (!loaded_ || panelSizePx_.x == 0 || panelSizePx_.y == 0) return happened;
  if (!placeCamera()) return true;
  liveFront_.setPictureSize(pictureSize());
  happened |= takeFrame();
  happened |= ask(now);
  happened |= takeReference();
  happened |= askReference(now);
  for (size_t i = 0; i < kPanelCount; ++i) {
    happened |= takePicture(i);
    happened |= takeErrors(i, now);
    if (panels_[i].isAutomatic) chooseTechnique(i);
    happened |= postJob(i);
  }
  if (happened) quietSince_ = now;
  timePictures(now);
  forgetOldRequests();
  return happened;
}

bool Session::takeScene() {
  std::optional<LoadResult> result = loader_->tryTake();
  if (!result || result->name != loading_) return false;
  loading_.clear();
  loadError_ = std::move(result->error);
  if (!result->loaded) return true;

  referenceWorker_->cancel();
  for (const auto& worker : warpWorkers_) worker->cancel();
  for (const auto& worker : judgeWorkers_) worker->cancel();
  retireScene();
  loaded_ = std::move(result->loaded);
  transport_ = knobs_.transport;
  loaded_->source->setTransport(transport_);
  serverError_.clear();
  viewError_.clear();
  referenceError_.clear();
  knobs_.march = loaded_->scene.march;
  knobs_.isFrozen = false;
  view_ = usableView_ = loaded_->scene.views.front();
  frame_.reset();
  reference_.reset();
  asked_ = {};
  referenceAsked_ = {};
  outdatedAt_.clear();
  arrivals_.clear();
  askedFor_.clear();
  answeredId_ = requestId_;
  drawnIds_ = {};
  judged_ = {};
  liveFront_.clear();
  timing_.reset();
  timed_ = {};
  isDrawing_ = {};
  for (size_t i = 0; i < kPanelCount; ++i) {
    jobs_[i] = {};
    Panel fresh;
    fresh.technique = panels_[i].technique;
    fresh.isAutomatic = panels_[i].isAutomatic;
    fresh.showsHeatMap = panels_[i].showsHeatMap;
    panels_[i] = std::move(fresh);
  }
  return true;
}

void Session::retireScene() {
  std::erase_if(retired_, [](const std::future<void>& one) { return one.wait_for(std::chrono::seconds(0)) == std::future_status::ready; });
  if (!loaded_) return;
  loaded_->source->requestStop();
  wanted_ = asked_ = {};
  retired_.push_back(std::async(std::launch::async, [scene = std::move(loaded_)]() mutable { scene.reset(); }));
}

bool Session::placeCamera() {
  const glm::uvec2 size = pictureSize();
  try {
    camera_ = makeCamera(loaded_->scene, view_, size.x, size.y);
  } catch (const std::exception& error) {
    viewError_ = error.what();
    const bool hasOther = view_ != usableView_;
    view_ = usableView_;
    return hasOther && placeCamera();
  }
  if (view_ != usableView_) viewError_.clear();
  usableView_ = view_;
  return true;
}

bool Session::takeFrame() {
  std::optional<ServedFrame> served = loaded_->source->tryTake();
  if (!served) return false;
  answeredId_ = served->requestId;
  serverError_ = std::move(served->error);
  if (!served->frame) return true;
  frame_ = std::move(served->frame);
  frameBytes_ = served->bytes;
  ++framesReceived_;
  frameArrivedAt_ = served->arrivedAt;
  arrivals_[served->requestId] = {served->latency, served->bytes};
  serverRate_.tick(served->arrivedAt);
  return true;
}

bool Session::takePicture(size_t index) {
  std::optional<WarpResult> result = warpWorkers_[index]->tryTake();
  if (!result || result->job.marcher != loaded_->display) return false;
  if (result->job.timedAs) {
    takeTime(index, *result);
    return true;
  }
  if (result->job == jobs_[index]) isDrawing_[index] = false;
  Panel& panel = panels_[index];
  drawnIds_[index] = result->requestId();
  panel.error = std::move(result->error);
  if (!result->picture) return true;
  panel.picture = result->picture;
  panel.drawn = result->job.technique;
  panel.requestId = result->requestId();
  if (const auto arrival = arrivals_.find(panel.requestId); arrival != arrivals_.end()) {
    panel.latency = arrival->second.latency;
    panel.frameBytes = arrival->second.bytes;
  }
  panel.buildMs = result->buildMs;
  panel.drawMs = result->drawMs;
  panel.displayMs = millisecondsBetween(result->finishedAt, std::chrono::steady_clock::now());
  panel.configuration = configurationOf(result->job);
  judge(index, std::move(*result));
  return true;
}

bool Session::ask(TimePoint now) {
  if (transport_ != knobs_.transport) {
    transport_ = knobs_.transport;
    loaded_->source->setTransport(transport_);
  }
  wanted_ = {loaded_->source, cameraOfSize(serverSize()), knobs_.march, knobs_.transport.codec};
  if (wanted_ == asked_) {
    outdatedAt_.erase(requestId_);  // the camera may have come back
    return false;
  }
  outdatedAt_.try_emplace(requestId_, now);
  if (knobs_.isFrozen && frame_) return false;
  asked_ = wanted_;
  loaded_->source->post({++requestId_, wanted_.camera, wanted_.settings}, now);
  askedFor_[requestId_] = {wanted_.settings, wanted_.codec, knobs_.serverSidePx};
  return true;
}

bool Session::postJob(size_t index) {
  WarpJob job;
  job.technique = panels_[index].technique;
  if (job.technique->usesFrame) {
    if (!frame_) return false;
    job.frame = frame_;
  }
  job.reference = reference_;
  job.marcher = loaded_->display;
  job.camera = cameraOfSize(pictureSize());
  job.settings = knobs_.warp;
  if (const std::optional<Configuration>& choice = panels_[index].choice) {
    job.settings = choice->warp(job.settings);
  }
  job.settings.knobs = job.settings.knobs.only(job.technique->knobs);  // others' do not make it draw
  job.settings.reference = referenceWanted_.settings;
  job.background = loaded_->scene.background;
  job.uncovered = knobs_.uncovered;
  if (job == jobs_[index]) return false;
  stopTiming();
  jobs_[index] = job;
  isDrawing_[index] = true;
  warpWorkers_[index]->post(std::move(job));
  return true;
}

bool Session::mayBeShown(uint64_t requestId) const {
  if (requestId > answeredId_) return true;  // also the newest
  if (frame_ && requestId == frame_->requestId) return true;
  for (size_t i = 0; i < kPanelCount; ++i) {
    if (panels_[i].picture && requestId == panels_[i].requestId) return true;
    if (jobs_[i].frame && requestId >= drawnIds_[i] && requestId <= jobs_[i].frame->requestId) return true;
  }
  return false;
}

void Session::forgetOldRequests() {
  std::erase_if(outdatedAt_, [this](const auto& request) { return !mayBeShown(request.first); });
  std::erase_if(arrivals_, [this](const auto& arrival) { return !mayBeShown(arrival.first); });
  std::erase_if(askedFor_, [this](const auto& asked) { return !mayBeShown(asked.first); });
}

bool Session::close(std::chrono::milliseconds patience) {
  const auto deadline = std::chrono::steady_clock::now() + patience;
  loader_->requestStop();
  retireScene();
  referenceWorker_->requestStop();
  for (const auto& worker : warpWorkers_) worker->requestStop();
  for (const auto& worker : judgeWorkers_) worker->requestStop();
  bool ended = loader_->waitForEnd(deadline) && referenceWorker_->waitForEnd(deadline);
  for (const auto& worker : warpWorkers_) ended = ended && worker->waitForEnd(deadline);
  for (const auto& worker : judgeWorkers_) ended = ended && worker->waitForEnd(deadline);
  for (const std::future<void>& scene : retired_) ended = ended && scene.wait_until(deadline) == std::future_status::ready;
  return ended;
}

std::optional<SourceStatus> Session::sourceStatus() const {
  if (!loaded_) return std::nullopt;
  return loaded_->source->status();
}

std::optional<double> Session::frameAgeMs(TimePoint now) const {
  if (!frame_) return std::nullopt;
  return std::max(0.0, millisecondsBetween(frameArrivedAt_, now));
}

uint32_t Session::screenPixels() const {
  uint32_t edge = std::max(1u, knobs_.screenPixels);
  if (knobs_.screenPixels == 0)
    while (uint64_t{panelSizePx_.x / edge} * (panelSizePx_.y / edge) > kFluentPixels) ++edge;
  return edge;
}

glm::uvec2 Session::pictureSize() const {
  if (panelSizePx_.x == 0 || panelSizePx_.y == 0) return glm::uvec2(0);
  return glm::clamp(panelSizePx_ / screenPixels(), glm::uvec2(1), glm::uvec2(kMaxImageSide));
}

glm::uvec2 Session::serverSize() const {
  const glm::uvec2 picture = pictureSize();
  if (picture.x == 0) return picture;
  const double scale = static_cast<double>(knobs_.serverSidePx) / std::max(picture.x, picture.y);
  return glm::max(glm::uvec2(1), glm::uvec2(glm::round(glm::dvec2(picture) * scale)));
}

Camera Session::cameraOfSize(const glm::uvec2& size) const {
  Camera camera = camera_;
  camera.width = size.x;
  camera.height = size.y;
  return camera;
}

std::optional<double> Session::ageMs(size_t panel, TimePoint now) const {
  const Panel& shown = panels_[panel];
  if (!shown.picture || !shown.drawn->usesFrame) return std::nullopt;
  if (isCurrent(shown.requestId)) return 0.0;
  const auto outdated = outdatedAt_.find(shown.requestId);
  return outdated == outdatedAt_.end() ? 0.0 : millisecondsBetween(outdated->second, now);
}

}  // namespace warpscope
