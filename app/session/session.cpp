// What the parts of a session tell each other.
// See session.h.
#include "app/session/session.h"

#include <algorithm>
#include <utility>

#include "app/frames/coarsening.h"
#include "app/shell/output_files.h"

namespace warpscope {
namespace {

/// What draws with `warp` the frames that `asked` for.
Configuration configurationFor(const WarpDescriptor& technique, const WarpSettings& warp, const WantedFrame& asked) {
  Configuration configuration;
  configuration.technique = &technique;
  configuration.march = asked.march;
  configuration.serverSidePx = asked.serverSidePx;
  configuration.codec = asked.codec;
  configuration.knobs = warp.knobs;
  return normalized(configuration);
}

/// `next`, a scene's, with what a hand has turned of what is sent of frames where that scene says nothing of it. `now` began as `own`.
MarchSettings withTurned(MarchSettings next, const MarchSettings& now, const MarchSettings& own) {
  for (const MarchKnob& row : marchKnobs())
    if (row.shapes != FramePart::picture && row.get(now) != row.get(own) && row.get(next) == row.knob->defaultValue) row.set(next, row.get(now));
  return next;
}

}  // namespace

Session::Session(const SessionSettings& settings, const std::function<void()>& onNews)
    : platform_(settings.platform),
      resources_(settings.resources),
      makeJudge_(settings.makeJudge),
      onNews_(onNews),
      opening_(onNews, marchCrew_),
      truth_(onNews, marchCrew_),
      plan_(onNews, marchCrew_),
      ray_(onNews, marchCrew_),
      fair_(settings.platform, settings.resources, onNews, makeCrew(Crew::kOfPictures)),
      moving_(onNews, marchCrew_),
      exporting_(settings.platform, settings.resources, onNews, marchCrew_) {
  setKnobs(settings.knobs);
  for (const PanelSettings& panel : settings.panels) panels_.push_back(makePanel(panel, ++lastPanelId_));
}

void Session::setKnobs(const LiveSettings& knobs) {
  knobs_ = knobs;
  view_.setScreenPixels(knobs.screenPixels);
}

void Session::setPanelSize(const glm::uvec2& sizePx) {
  areaPx_ = sizePx;
  view_.setArea(sizePx);
}

void Session::setView(size_t panel, const View& view) {
  if (LivePanel::OwnCamera* own = panels_[panel].ownCamera())
    own->view.set(view);
  else
    view_.set(view);
}

void Session::resetView() {
  if (const Scene* shown = scene()) view_.set(shown->views.front());
}

void Session::resetView(size_t panel) {
  if (const Scene* shown = scene()) setView(panel, shown->views.front());
}

void Session::dismissErrors() {
  opening_.dismissError();
  view_.dismissError();
  frames_.dismissError();
  recordingError_.clear();
  truth_.setError("");
  for (LivePanel& panel : panels_) {
    if (LivePanel::OwnCamera* own = panel.ownCamera()) {
      own->view.dismissError();
      own->truth.setError("");
    }
  }
}

const std::string& Session::error() const {
  for (const std::string* error : {&opening_.error(), &recordingError_, &view_.error(), &frames_.error()})
    if (!error->empty()) return *error;
  for (const LivePanel& panel : panels_) {
    const LivePanel::OwnCamera* own = panel.ownCamera();
    if (own != nullptr && !own->view.error().empty()) return own->view.error();
    if (own != nullptr && !own->truth.error().empty()) return own->truth.error();
  }
  return truth_.error();
}

std::vector<TechniqueInUse> Session::techniquesInUse() const {
  std::vector<TechniqueInUse> techniques;
  for (size_t i = 0; i < panels_.size(); ++i) {
    if (panel(i).isHidden) continue;
    techniques.push_back({panel(i).technique, warpSettingsOf(i).knobs});
    // One that was chosen may wait for what it draws.
    if (const auto& choice = panel(i).choice; choice && choice->technique != panel(i).technique) techniques.push_back({choice->technique, choice->knobs});
  }
  return techniques;
}

LinkSign Session::linkSign(TimePoint now) const {
  if (playback_.isOpen() && !playback_.recording().links.empty()) return linkAt(playback_.recording(), playback_.seconds());
  return signOf(knobs_.transport.link, hasOutage(now));
}

TransportSettings Session::transportAt(TimePoint now) const {
  TransportSettings transport = knobs_.transport;
  if (!hasOutage(now)) return transport;
  // One outage that begins as the link changes (link_model.h); it is over when the link is the user's again.
  for (net::LinkSettings* const way : {&transport.link.up, &transport.link.down}) {
    way->outageMs = static_cast<double>(outageLength_.count());
    way->outageIntervalMs = way->outageMs + 1.0;
    way->outagesAreRandom = false;
  }
  return transport;
}

ReferenceJob Session::truthFrom(const LiveView& view) const {
  return {opening_.current()->display, view.cameraOfSize(pictureSize()), knobs_.march.render, scene()->background};
}

bool Session::update(TimePoint now) {
  bury();
  bool happened = takeScene();
  if (!scene() || pictureSize().x == 0) return happened;
  view_.set(playback_.update(view_.get(), now));
  view_.set(motion_.update(view_.get(), now));
  followRecordedFunction();
  if (!view_.place(*scene())) return true;
  liveFront_.setPictureSize(pictureSize());
  happened |= followFrames(now);
  happened |= truth_.take();
  if (whyNoTruth().empty()) happened |= truth_.follow(truthFrom(view_), now);
  for (size_t i = 0; i < panels_.size(); ++i) {
    happened |= followOwnCamera(panels_[i], now);
    happened |= takePicture(panels_[i], i);
    happened |= takeErrors(panels_[i], now);
    if (panel(i).isAutomatic) happened |= chooseTechnique(i);
    happened |= postJob(i);
  }
  happened |= followMoving(now);
  if (const SampleFramePtr& frame = frames_.newest()) happened |= plan_.follow(opening_.current()->display, *frame);
  happened |= plan_.take();
  happened |= followRay();
  happened |= fair_.take();
  happened |= takeEndedRecordings(std::chrono::steady_clock::time_point::min());
  record(now);
  timing_.update(panels_, isAtRest(), happened, now);
  plan_.measure(showsPlan_ && timing_.isOver(panels_, now));
  frames_.forgetOld([this](uint64_t id) { return std::any_of(panels_.begin(), panels_.end(), [&](const LivePanel& one) { return one.mayShow(id); }); });
  return happened;
}

bool Session::followFrames(TimePoint now) {
  if (playback_.isOpen()) {
    std::optional<LivePlayback::Shown> shown = playback_.take();
    if (!shown) return playback_.isPlaying();
    shown->asked.codec = knobs_.transport.codec;
    shown->served.arrivedAt = now;
    frames_.show(std::move(shown->served), shown->asked);
    if (functionAt(playback_.recording(), playback_.seconds()) != nullptr) frames_.classify(scene()->transferFunction);
    return true;
  }
  const bool happened = frames_.take();
  frames_.setTransport(transportAt(now));
  // What is recorded is to be shown by any technique.
  const MarchSettings march = isRecording() ? knobs_.march : neededBy(techniquesInUse(), knobs_.march);
  const WantedFrame wanted{view_.cameraOfSize(serverSize()), view_.get(), march, knobs_.transport.codec, knobs_.serverSidePx, functionVersion_};
  return frames_.ask(wanted, knobs_.isFrozen, now) || happened;
}

std::string Session::whyFunctionIsFixed() const {
  if (!scene()) return "there is no scene yet";
  if (playback_.isOpen()) return "the frames were recorded as they are";
  if (opening_.current()->display->capabilities().functionChange == FunctionChange::refused) return "the server has the volume, and chooses how it looks";
  return "";
}

void Session::setTransferFunction(TransferFunction function) {
  if (const std::string why = whyFunctionIsFixed(); !why.empty()) throw UsageError(why);
  if (function == scene()->transferFunction) return;
  validate(function);
  timing_.stop(panels_);
  MarcherPtr display = opening_.current()->display->withTransferFunction(function);
  if (!frames_.setTransferFunction(function, ++functionVersion_)) throw UsageError("the server has the volume, and chooses how it looks");
  showFunction(std::move(function), std::move(display));
}

void Session::showFunction(TransferFunction function, MarcherPtr display) {
  opening_.setTransferFunction(std::move(function), std::move(display));
  liveFront_.clear();
  fair_.clear();
}

void Session::followRecordedFunction() {
  const TransferFunction* const function = playback_.isOpen() ? functionAt(playback_.recording(), playback_.seconds()) : nullptr;
  if (function == nullptr || *function == scene()->transferFunction) return;
  timing_.stop(panels_);
  MarcherPtr display = opening_.current()->display;
  if (display->capabilities().functionChange != FunctionChange::refused) display = display->withTransferFunction(*function);
  showFunction(*function, std::move(display));
  frames_.classify(*function);
}

void Session::measureNow() {
  const SampleFramePtr& frame = frames_.newest();
  const std::optional<WantedFrame> asked = frame ? frames_.askedBy(frame->requestId) : std::nullopt;
  if (!asked) return;
  if (!isOfFunctionNow(*asked)) return fair_.refuse("the frame is from before the transfer function changed: let another one come");
  FairJob job;
  for (size_t i = 0; i < panels_.size(); ++i) {
    const WarpDescriptor& technique = *panel(i).technique;
    if (panel(i).isHidden || !technique.usesFrame || !lackOf(technique, frame->settings).empty()) continue;
    Configuration configuration = configurationFor(technique, warpSettingsOf(i), *asked);
    if (std::ranges::find(job.configurations, configuration) == job.configurations.end()) job.configurations.push_back(std::move(configuration));
  }
  if (job.configurations.empty()) return;
  job.scene = std::make_shared<const Scene>(*scene());
  job.marcher = opening_.current()->display;
  job.frame = frame;
  job.frameView = asked->view;
  job.sizePx = pictureSize();
  job.reference = knobs_.march.render;
  fair_.start(std::move(job));
}

void Session::startRecording(const std::filesystem::path& file, const std::string& text) {
  if (!scene()) throw InputError("there is no scene yet");
  // Nobody waits for a slow disk here. What is left to be written has mostly been for a while.
  const auto requireWritten = [&] {
    takeEndedRecordings(std::chrono::steady_clock::now() + std::chrono::milliseconds(20));
    for (const EndedRecording& one : endedRecordings_)
      if (isSameFile(one.file, file)) throw InputError(file.string() + ": what was recorded before is still being written to it");
  };
  requireWritten();
  if (recorder_) {
    stopRecording();
    requireWritten();
  }
  recordingFailure_.clear();
  recorder_ = std::make_unique<RecordingWriter>(file, *scene(), text, makeCrew(Crew::kOfMarches));
  recordingFile_ = file;
  recordingSince_.reset();
  recordedFrame_.reset();
  recordedLink_ = {};
  recordedFunction_ = scene()->transferFunction;  // as the file begins
}

size_t Session::stopRecording() {
  if (!recorder_) return 0;
  const size_t leftOut = recorder_->framesLeftOut();
  // What waits is written elsewhere: a disk may take its time.
  endedRecordings_.push_back({recordingFile_, std::async(std::launch::async, [ended = std::move(recorder_)] { return ended->finish(); })});
  return leftOut;
}

bool Session::takeEndedRecordings(std::chrono::steady_clock::time_point until) {
  return std::erase_if(endedRecordings_, [&](EndedRecording& one) {
           if (one.trouble.wait_until(until) != std::future_status::ready) return false;
           if (std::string error = one.trouble.get(); !error.empty()) recordingError_ = recordingFailure_ = std::move(error);
           return true;
         }) > 0;
}

void Session::startExport(const std::filesystem::path& path, const ExportLook& look) {
  if (!playback_.isOpen()) throw InputError("there is no recording on show");
  ExportJob job;
  job.files = exportedAs(path);
  job.recording = playback_.sharedRecording();
  for (size_t i = 0; i < panels_.size(); ++i)
    if (!panel(i).isHidden) job.columns.push_back({{panel(i).technique, warpSettingsOf(i).knobs}, panel(i).content, panel(i).contentRange});
  showWhatThereIs(job.columns, whyNoTruth().empty());
  if (needsMarcher(job.columns, look.hasErrors)) {
    if (!whyNoTruth().empty()) throw InputError(whyNoTruth());
    job.marcher = opening_.current()->display;
    if (const TransferFunction* const first = functionAt(*job.recording, 0.0)) job.marcher = job.marcher->withTransferFunction(*first);
  }
  job.look = look;
  if (look.sizePx.x == 0) job.look.sizePx = pictureSize();
  exporting_.start(std::move(job));
}

std::optional<size_t> Session::placeOf(uint64_t id) const {
  for (size_t i = 0; i < panels_.size(); ++i)
    if (panels_[i].shown().id == id) return i;
  return std::nullopt;
}

void Session::record(TimePoint now) {
  if (!recorder_) return;
  if (std::string error = recorder_->error(); !error.empty()) {
    recordingError_ = recordingFailure_ = std::move(error);
    stopRecording();
    return;
  }
  if (!recordingSince_) recordingSince_ = now;
  const double seconds = std::chrono::duration<double>(now - *recordingSince_).count();
  recorder_->addView(seconds, view_.get());
  if (recordedFunction_ != scene()->transferFunction) recorder_->addFunction(seconds, recordedFunction_ = scene()->transferFunction);
  if (LinkSign sign = linkSign(now); sign != recordedLink_) recorder_->addLink(seconds, recordedLink_ = std::move(sign));
  // One whose copy of the volume was only classified anew is there already.
  const SampleFramePtr& frame = frames_.newest();
  if (frame && frame->requestId != recordedFrame_) recorder_->addFrame(seconds, frame), recordedFrame_ = frame->requestId;
}

bool Session::followRay() {
  const std::optional<size_t> place = lookedAt_ ? placeOf(lookedAt_->panel) : std::nullopt;
  if (!place) {
    lookedAt_.reset();
    ray_.lookAway();
    return false;
  }
  bool happened = ray_.take();
  const PanelPixels* const pixels = panel(*place).currentPixels();
  if (pixels == nullptr) return happened;  // until the picture was judged, the last ray stays
  const glm::uvec2 pixel = pixels->at(lookedAt_->place);
  const RayOfPixel ray = rayBehind(pixels->inputs(), pixel);
  MarchSettings settings = ray.isServers ? pixels->frame->settings : knobs_.march;
  settings.sample.segments = knobs_.march.sample.segments;  // that the frame lacks where nothing on show draws them
  std::optional<RayOfPixel> own;
  if (ray.sample) own = RayOfPixel{false, pixels->inputs().camera, pixel, std::nullopt, false};
  happened |= ray_.follow({scene()->volume, scene()->transferFunction, ray, settings, ray.isGap || own ? pixels->frame : nullptr, own});
  return happened;
}

bool Session::takeScene() {
  const SceneOpening::Outcome outcome = opening_.take();
  if (outcome != SceneOpening::Outcome::opened) return outcome != SceneOpening::Outcome::nothing;
  ++sceneCount_;
  stopRecording();  // it is of the scene before
  truth_.clear();
  plan_.clear();
  ray_.clear();
  fair_.clear();
  moving_.clear();
  const SceneArrangement arranged = opening_.current()->arrangement;
  for (size_t i = 0; i < panels_.size(); ++i) {
    panels_[i].clear();
    const std::optional<View> ownView = i < arranged.ownViews.size() ? arranged.ownViews[i] : std::nullopt;
    if (LivePanel::OwnCamera* own = panels_[i].ownCamera()) own->view.begin(ownView.value_or(scene()->views.front()));
  }
  frames_.begin(*opening_.current()->source, knobs_.transport);
  playback_.begin(opening_.current()->recorded);
  const bool isScenesOwn = sceneCount_ == 1 || opening_.current()->recorded != nullptr;
  knobs_.march = arranged.march ? *arranged.march : isScenesOwn ? scene()->march : withTurned(scene()->march, knobs_.march, ownMarch_);
  ownMarch_ = arranged.march.value_or(scene()->march);
  knobs_.isFrozen = false;
  view_.begin(arranged.view.value_or(scene()->views.front()));
  liveFront_.clear();
  timing_.clear();
  scenesFunctionVersion_ = functionVersion_;
  if (arranged.transferFunction && whyFunctionIsFixed().empty()) setTransferFunction(*arranged.transferFunction);
  return true;
}

bool Session::takePicture(LivePanel& panel, size_t index) {
  std::optional<WarpResult> result = panel.take();
  if (!result || result->job.scene != sceneCount_) return false;
  if (result->job.timedAs) {
    takeTime(index, *result);
    return true;
  }
  seeMoving(panel, *result);
  const auto arrival = frames_.arrivalOf(result->requestId());
  auto configuration = configurationOf(*result);
  const std::optional<WantedFrame> asked = frames_.askedBy(result->requestId());
  std::string leftOut = result->job.frame && asked ? coarseningText(asked->march, result->job.frame->settings) : "";
  panel.show(std::move(*result), arrival, std::move(configuration), std::move(leftOut));
  return true;
}

void Session::seeMoving(const LivePanel& panel, const WarpResult& result) {
  const MarcherCapabilities marcher = opening_.current()->display->capabilities();
  const uint64_t id = panel.shown().id;
  if (!result.sparse || marcher.pace == MarchPace::followsCamera || marcher.volume != VolumePlace::here)
    moving_.forget(id);  // that of a server elsewhere has other things to do
  else
    moving_.see({id, result.job.technique, result.job.camera, result.sparse});
}

bool Session::followMoving(TimePoint now) {
  const std::vector<MovingErrors::Found> found = moving_.take(now);
  for (const MovingErrors::Found& one : found)
    if (const std::optional<size_t> place = placeOf(one.panel)) panels_[*place].note(one, now);
  moving_.follow(truthFrom(view_), now);
  return !found.empty();
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
  LivePanel::ErrorNews news = panel.takeErrors(truthOf(panel), now);
  if (!news.error.empty()) {
    LivePanel::OwnCamera* const own = panel.ownCamera();
    (own != nullptr ? own->truth : truth_).setError(std::move(news.error));
  }
  if (news.found) liveFront_.addError(news.found->configuration, news.found->sizePx, news.found->angleDeg, news.found->flip);
  return news.happened;
}

std::optional<Configuration> Session::configurationOf(const WarpResult& result) const {
  if (result.plan.way() != PictureWay::technique) return std::nullopt;  // the technique is not what is seen
  const WarpJob& drawn = result.job;
  const std::optional<WantedFrame> asked = drawn.frame ? frames_.askedBy(drawn.frame->requestId) : std::nullopt;
  if (!asked || isCoarsened(asked->march, drawn.frame->settings)) return std::nullopt;  // nobody chose it
  if (!isOfFunctionNow(*asked)) return std::nullopt;
  if (!lackOf(*drawn.technique, drawn.frame->settings).empty()) return std::nullopt;    // there is nothing to be seen
  return configurationFor(*drawn.technique, drawn.settings, *asked);
}

bool Session::isAtRest() const {
  const bool isPlaybackAtRest = !playback_.isOpen() || playback_.isAtRest();
  const bool isServerAtRest = isPlaybackAtRest && !frames_.isUnderWay() && !frames_.isToBeRefined() && (frames_.isWhatIsWanted() || knobs_.isFrozen);
  if (!loading().empty() || !isServerAtRest || !truth_.isAsked() || fair_.isMeasuring() || moving_.isAtWork() || exporting_.isAtWork()) return false;
  return std::all_of(panels_.begin(), panels_.end(), [this](const LivePanel& panel) {
    const bool isAsked = panel.ownCamera() == nullptr || panel.shown().isHidden || panel.ownCamera()->truth.isAsked();
    return isAsked && panel.isAtRest(truthOf(panel));
  });
}

bool Session::close(std::chrono::milliseconds patience) {
  stopRecording();
  opening_.requestStop();
  truth_.requestStop();
  plan_.requestStop();
  ray_.requestStop();
  fair_.requestStop();
  moving_.requestStop();
  exporting_.requestStop();
  for (LivePanel& panel : panels_) panel.requestStop();
  takeEndedRecordings(std::chrono::steady_clock::now() + std::max(patience, kRecordingPatience));
  if (!endedRecordings_.empty() && recordingFailure_.empty()) recordingFailure_ = "its end could not be written in time";
  const auto deadline = std::chrono::steady_clock::now() + patience;
  const auto hasEnded = [&](const LivePanel& panel) { return panel.waitForEnd(deadline); };
  return endedRecordings_.empty() && opening_.waitForEnd(deadline) && truth_.waitForEnd(deadline) && plan_.waitForEnd(deadline) && ray_.waitForEnd(deadline) && fair_.waitForEnd(deadline) &&
         moving_.waitForEnd(deadline) && exporting_.waitForEnd(deadline) &&
         std::all_of(panels_.begin(), panels_.end(), hasEnded) && std::all_of(removed_.begin(), removed_.end(), hasEnded);
}

std::optional<SourceStatus> Session::sourceStatus() const {
  if (!opening_.current()) return std::nullopt;
  return opening_.current()->source->status();
}

std::optional<double> Session::ageMs(size_t panel, TimePoint now) const {
  const Panel& shown = this->panel(panel);
  if (!shown.picture || !shown.drawn->usesFrame) return std::nullopt;
  return playback_.isOpen() ? playback_.ageMs(shown.requestId) : frames_.ageMs(shown.requestId, now);
}

std::optional<double> Session::angleDeg(size_t panel) const {
  const SampleFramePtr& frame = frames_.newest();
  if (!frame || pictureSize().x == 0 || pictureSize().y == 0) return std::nullopt;
  return angleBetweenDeg(frame->camera, viewOf(panels_[panel]).cameraOfSize(pictureSize()));
}

}  // namespace warpscope
