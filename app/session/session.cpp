// What the parts of a session tell each other.
// See session.h.
#include "app/session/session.h"

#include <algorithm>
#include <utility>

#include "app/frames/coarsening.h"

namespace warpscope {

Session::Session(const SessionSettings& settings, const std::function<void()>& onNews) : opening_(onNews), truth_(onNews), plan_(onNews) {
  setKnobs(settings.knobs);
  for (size_t i = 0; i < kPanelCount; ++i) {
    LivePanel& panel = panels_.emplace_back(makeWarpWorker(settings.platform, settings.resources, onNews),
                                            makeJudgeWorker(settings.makeJudge, onNews));
    panel.setTechnique(*settings.techniques[i]);
    panel.setAutomatic(settings.isAutomatic[i]);
  }
}

void Session::setKnobs(const LiveSettings& knobs) {
  knobs_ = knobs;
  view_.setScreenPixels(knobs.screenPixels);
}

void Session::setTechnique(size_t panel, const WarpDescriptor& technique) {
  panels_[panel].setAutomatic(false);
  panels_[panel].setChoice(std::nullopt, "");
  choices_[panel].clear();
  useTechnique(panels_[panel], technique);
}

void Session::useTechnique(LivePanel& panel, const WarpDescriptor& technique) {
  if (panel.setTechnique(technique)) timing_.stop(panels_);
}

void Session::choose(size_t panel, const Configuration& configuration) {
  const WarpDescriptor& technique = *configuration.technique;
  setTechnique(panel, technique);
  knobs_.march.render = configuration.march.render;
  takeOver(configuration, knobs_.march, knobs_.warp);
  takePanelKnobs(panel, configuration);
  if (!technique.usesFrame) return;
  knobs_.serverSidePx = configuration.serverSidePx;
  knobs_.transport.codec = configuration.codec;
}

void Session::takePanelKnobs(size_t panel, const Configuration& configuration) {
  for (const Knob* knob : configuration.technique->knobs)
    if (knob->isOfPanel) knobs_.panelKnobs[panel].set(*knob, configuration.knobs[*knob]);
}

void Session::resetView() {
  if (const Scene* shown = scene()) view_.set(shown->views.front());
}

void Session::dismissErrors() {
  opening_.dismissError();
  view_.dismissError();
  frames_.dismissError();
  truth_.setError("");
}

const std::string& Session::error() const {
  for (const std::string* error : {&opening_.error(), &view_.error(), &frames_.error()})
    if (!error->empty()) return *error;
  return truth_.error();
}

bool Session::update(TimePoint now) {
  bool happened = takeScene();
  if (!scene() || pictureSize().x == 0) return happened;
  if (!view_.place(*scene())) return true;
  liveFront_.setPictureSize(pictureSize());
  happened |= frames_.take();
  frames_.setTransport(knobs_.transport);
  std::vector<TechniqueInUse> techniques;
  for (size_t i = 0; i < kPanelCount; ++i) {
    techniques.push_back({panel(i).technique, warpSettingsOf(i).knobs});
    // One that was chosen may wait for what it draws.
    if (const auto& choice = panel(i).choice; choice && choice->technique != panel(i).technique) techniques.push_back({choice->technique, choice->knobs});
  }
  happened |= frames_.ask({view_.cameraOfSize(serverSize()), neededBy(techniques, knobs_.march), knobs_.transport.codec, knobs_.serverSidePx}, knobs_.isFrozen, now);
  happened |= truth_.take();
  happened |= truth_.follow({opening_.current()->display, view_.cameraOfSize(pictureSize()), knobs_.march.render, scene()->background}, now);
  for (size_t i = 0; i < kPanelCount; ++i) {
    happened |= takePicture(panels_[i], i);
    happened |= takeErrors(panels_[i], now);
    if (panel(i).isAutomatic) happened |= chooseTechnique(i);
    happened |= postJob(i);
  }
  if (const SampleFramePtr& frame = frames_.newest()) happened |= plan_.follow(opening_.current()->display, *frame);
  happened |= plan_.take();
  timing_.update(panels_, isAtRest(), happened, now);
  plan_.measure(showsPlan_ && timing_.isOver(panels_, now));
  frames_.forgetOld([this](uint64_t id) { return std::any_of(panels_.begin(), panels_.end(), [&](const LivePanel& one) { return one.mayShow(id); }); });
  return happened;
}

bool Session::takeScene() {
  const SceneOpening::Outcome outcome = opening_.take();
  if (outcome != SceneOpening::Outcome::opened) return outcome != SceneOpening::Outcome::nothing;
  truth_.clear();
  plan_.clear();
  for (LivePanel& panel : panels_) panel.clear();
  for (TechniqueChoice& choice : choices_) choice.clear();
  frames_.begin(*opening_.current()->source, knobs_.transport);
  knobs_.march = scene()->march;
  knobs_.isFrozen = false;
  view_.begin(scene()->views.front());
  liveFront_.clear();
  timing_.clear();
  return true;
}

bool Session::takePicture(LivePanel& panel, size_t index) {
  std::optional<WarpResult> result = panel.take();
  if (!result || result->job.marcher != opening_.current()->display) return false;
  if (result->job.timedAs) {
    takeTime(index, *result);
    return true;
  }
  const auto arrival = frames_.arrivalOf(result->requestId());
  auto configuration = configurationOf(*result);
  const std::optional<WantedFrame> asked = frames_.askedBy(result->requestId());
  std::string leftOut = result->job.frame && asked ? coarseningText(asked->march, result->job.frame->settings) : "";
  panel.show(std::move(*result), arrival, std::move(configuration), std::move(leftOut));
  return true;
}

void Session::takeTime(size_t index, const WarpResult& result) {
  if (!timing_.finish(index)) return;
  panels_[index].finishTiming();
  const std::optional<Configuration>& configuration = panel(index).configuration;
  if (!result.timed || !configuration) return;
  const WarpJob& job = result.job;
  liveFront_.addTime(*configuration, {job.camera.width, job.camera.height}, angleBetweenDeg(job.frame->camera, job.camera), result.timed->frameMs());
}

bool Session::takeErrors(LivePanel& panel, TimePoint now) {
  LivePanel::ErrorNews news = panel.takeErrors(truth_, now);
  if (!news.error.empty()) truth_.setError(std::move(news.error));
  if (news.found) liveFront_.addError(news.found->configuration, news.found->sizePx, news.found->angleDeg, news.found->flip);
  return news.happened;
}

bool Session::chooseTechnique(size_t index) {
  LivePanel& panel = panels_[index];
  if (!frames_.newest()) return false;
  const MarchSettings& askable = knobs_.isFrozen ? frames_.newest()->settings : knobs_.march;
  auto made = choices_[index].choose(
      {frames_.newest(), askable, view_.cameraOfSize(pictureSize()), knobs_.budgetMs, knobs_.serverSidePx, front_}, liveFront_);
  if (!made) return false;
  if (made->configuration && made->configuration != panel.shown().choice) takePanelKnobs(index, *made->configuration);
  panel.setChoice(std::move(made->configuration), std::move(made->text));
  // Where the frame has nothing for it yet, the one before goes on until a frame comes that has.
  if (lackOf(*made->technique, frames_.newest()->settings).empty()) useTechnique(panel, *made->technique);
  return true;
}

WarpSettings Session::warpSettingsOf(size_t index) const {
  const Panel& shown = panel(index);
  const bool isChosen = shown.choice && shown.choice->technique == shown.technique;
  WarpSettings settings = isChosen ? shown.choice->warp(knobs_.warp) : knobs_.warp;
  for (const Knob* knob : shown.technique->knobs)
    if (knob->isOfPanel) settings.knobs.set(*knob, knobs_.panelKnobs[index][*knob]);
  settings.knobs = settings.knobs.only(shown.technique->knobs);  // others' do not make it draw
  return settings;
}

bool Session::postJob(size_t index) {
  LivePanel& panel = panels_[index];
  const Panel& shown = panel.shown();
  WarpJob job;
  job.technique = shown.technique;
  if (job.technique->usesFrame) {
    if (!frames_.newest()) return false;
    job.frame = frames_.newest();
  }
  job.reference = truth_.image();
  job.marcher = opening_.current()->display;
  job.camera = view_.cameraOfSize(pictureSize());
  job.settings = warpSettingsOf(index);
  job.settings.reference = truth_.wanted().settings;
  job.background = scene()->background;
  job.marks = knobs_.marks;
  job.takesShortcuts = knobs_.takesShortcuts && job.technique->usesFrame;
  if (!panel.isNew(job)) return false;
  timing_.stop(panels_);
  panel.post(std::move(job));
  return true;
}

std::optional<Configuration> Session::configurationOf(const WarpResult& result) const {
  if (result.plan.way() != PictureWay::technique) return std::nullopt;  // the technique is not what is seen
  const WarpJob& drawn = result.job;
  const std::optional<WantedFrame> asked = drawn.frame ? frames_.askedBy(drawn.frame->requestId) : std::nullopt;
  if (!asked || isCoarsened(asked->march, drawn.frame->settings)) return std::nullopt;  // nobody chose it
  if (!lackOf(*drawn.technique, drawn.frame->settings).empty()) return std::nullopt;    // there is nothing to be seen
  Configuration configuration;
  configuration.technique = drawn.technique;
  configuration.march = asked->march;
  configuration.serverSidePx = asked->serverSidePx;
  configuration.codec = asked->codec;
  configuration.knobs = drawn.settings.knobs;
  return normalized(configuration);
}

bool Session::isAtRest() const {
  const bool isServerAtRest = !frames_.isUnderWay() && !frames_.isToBeRefined() && (frames_.isWhatIsWanted() || knobs_.isFrozen);
  if (!loading().empty() || !isServerAtRest || !truth_.isAsked()) return false;
  return std::all_of(panels_.begin(), panels_.end(), [this](const LivePanel& panel) { return panel.isAtRest(truth_); });
}

bool Session::close(std::chrono::milliseconds patience) {
  const auto deadline = std::chrono::steady_clock::now() + patience;
  opening_.requestStop();
  truth_.requestStop();
  plan_.requestStop();
  for (LivePanel& panel : panels_) panel.requestStop();
  return opening_.waitForEnd(deadline) && truth_.waitForEnd(deadline) && plan_.waitForEnd(deadline) &&
         std::all_of(panels_.begin(), panels_.end(), [&](const LivePanel& panel) { return panel.waitForEnd(deadline); });
}

std::optional<SourceStatus> Session::sourceStatus() const {
  if (!opening_.current()) return std::nullopt;
  return opening_.current()->source->status();
}

std::optional<double> Session::ageMs(size_t panel, TimePoint now) const {
  const Panel& shown = this->panel(panel);
  if (!shown.picture || !shown.drawn->usesFrame) return std::nullopt;
  return frames_.ageMs(shown.requestId, now);
}

}  // namespace warpscope
