// Panels: which there are, what each shows, and the jobs that draw them.
// See session.h.
#include <algorithm>
#include <thread>
#include <utility>

#include "app/experiment/auto_choice.h"
#include "app/session/session.h"

namespace warpscope {

std::shared_ptr<Crew> Session::makeCrew(int nice) {
  constexpr unsigned int kFewCores = 8;
  return std::thread::hardware_concurrency() <= kFewCores ? std::make_shared<Crew>(0, nice) : nullptr;
}

LivePanel Session::makePanel(const PanelSettings& settings, uint64_t id) {
  return {id, settings, makeWarpWorker(platform_, resources_, onNews_, makeCrew(Crew::kOfPictures)), makeJudgeWorker(makeJudge_, onNews_, marchCrew_)};
}

bool Session::addPanel(const PanelSettings& settings) {
  if (panels_.size() >= kMaxPanels) return false;
  addPanel(makePanel(settings, ++lastPanelId_));
  return true;
}

void Session::addPanel(LivePanel panel) {
  timing_.stop(panels_);
  panels_.push_back(std::move(panel));
}

bool Session::removePanel(size_t panel) {
  if (panels_.size() <= 1 || panel >= panels_.size()) return false;
  timing_.stop(panels_);
  panels_[panel].requestStop();
  removed_.push_back(std::move(panels_[panel]));
  panels_.erase(panels_.begin() + static_cast<std::ptrdiff_t>(panel));
  return true;
}

void Session::movePanel(size_t from, size_t to) {
  if (from >= panels_.size() || to >= panels_.size()) return;
  timing_.stop(panels_);
  const auto begin = panels_.begin();
  const auto at = [&](size_t i) { return begin + static_cast<std::ptrdiff_t>(i); };
  if (from < to)
    std::rotate(at(from), at(from + 1), at(to + 1));
  else
    std::rotate(at(to), at(from), at(from + 1));
}

void Session::setHidden(size_t panel, bool isHidden) {
  if (this->panel(panel).isHidden == isHidden) return;
  timing_.stop(panels_);
  panels_[panel].setHidden(isHidden);
}

void Session::bury() {
  const auto now = std::chrono::steady_clock::now();
  std::erase_if(removed_, [&](const LivePanel& panel) { return panel.waitForEnd(now); });
}

void Session::setOwnCamera(size_t panel, bool hasOwn) {
  if (hasOwn == hasOwnCamera(panel)) return;
  timing_.stop(panels_);
  if (hasOwn)
    panels_[panel].giveCamera(view_.get(), onNews_, marchCrew_);
  else
    panels_[panel].takeCamera();
}

void Session::setTechnique(size_t panel, const WarpDescriptor& technique) {
  panels_[panel].setAutomatic(false);
  panels_[panel].setChoice(std::nullopt, "");
  panels_[panel].chooser().clear();
  useTechnique(panels_[panel], technique);
}

void Session::useTechnique(LivePanel& panel, const WarpDescriptor& technique) {
  if (panel.setTechnique(technique)) timing_.stop(panels_);
}

void Session::setPanel(size_t panel, const PanelSettings& settings) {
  setTechnique(panel, *settings.technique);
  panels_[panel].setAutomatic(settings.isAutomatic);
  panels_[panel].setKnobs(settings.knobs);
  setContent(panel, settings.content, settings.contentRange);
}

void Session::setPanels(const std::vector<PanelSettings>& panels) {
  while (panelCount() > panels.size()) removePanel(panelCount() - 1);
  for (size_t i = 0; i < panels.size(); ++i) {
    if (i >= panelCount()) addPanel(panels[i]);
    setPanel(i, panels[i]);
  }
}

void Session::setPanels(const std::vector<PanelSettings>& panels, const std::vector<uint64_t>& ids) {
  const auto placeOf = [&](uint64_t id) { return static_cast<size_t>(std::ranges::find(panels_, id, [](const LivePanel& panel) { return panel.shown().id; }) - panels_.begin()); };
  for (size_t i = panelCount(); i-- > 0;)
    if (std::ranges::find(ids, panels_[i].shown().id) == ids.end()) removePanel(i);  // but the last one, which gives way below
  for (size_t i = 0; i < panels.size(); ++i) {
    size_t at = placeOf(ids[i]);
    if (at == panelCount()) {
      if (panelCount() == kMaxPanels) removePanel(--at);
      addPanel(makePanel(panels[i], ids[i]));
    }
    movePanel(at, i);
    setPanel(i, panels[i]);
  }
  while (panelCount() > panels.size()) removePanel(panelCount() - 1);
}

void Session::choose(size_t panel, const Configuration& configuration, Says says) {
  const WarpDescriptor& technique = *configuration.technique;
  setTechnique(panel, technique);
  if (says == Says::all) {
    knobs_.march.render = configuration.march.render;
  } else {
    for (const MarchKnob& row : marchKnobs())
      if (row.knob->owner != KnobOwner::sampling && !row.knob->axis.key.empty()) row.set(knobs_.march, row.get(configuration.march));
  }
  takeOver(configuration, knobs_.march, knobs_.warp);
  takePanelKnobs(panels_[panel], configuration);
  if (!technique.usesFrame) return;
  knobs_.serverSidePx = configuration.serverSidePx;
  knobs_.transport.codec = configuration.codec;
}

void Session::takePanelKnobs(LivePanel& panel, const Configuration& configuration) {
  KnobValues knobs = panel.shown().knobs;
  for (const Knob* knob : configuration.technique->knobs)
    if (knob->isOfPanel) knobs.set(*knob, configuration.knobs[*knob]);
  panel.setKnobs(knobs);
}

bool Session::chooseTechnique(size_t index) {
  LivePanel& panel = panels_[index];
  if (!frames_.newest()) return false;
  const MarchSettings& askable = knobs_.isFrozen ? frames_.newest()->settings : knobs_.march;
  auto made = panel.chooser().choose(
      {frames_.newest(), askable, viewOf(panel).cameraOfSize(pictureSize()), knobs_.budgetMs, knobs_.serverSidePx, front_}, liveFront_);
  if (!made) return false;
  if (made->configuration && made->configuration != panel.shown().choice) takePanelKnobs(panel, *made->configuration);
  panel.setChoice(std::move(made->configuration), std::move(made->text));
  // Where the frame has nothing for it yet, the one before goes on until a frame comes that has.
  if (lackOf(*made->technique, frames_.newest()->settings).empty()) useTechnique(panel, *made->technique);
  return true;
}

bool Session::followOwnCamera(LivePanel& panel, TimePoint now) {
  LivePanel::OwnCamera* const own = panel.ownCamera();
  if (own == nullptr) return false;
  own->view.setArea(areaPx_);
  own->view.setScreenPixels(knobs_.screenPixels);
  if (!own->view.place(*scene())) return true;
  const bool happened = own->truth.take();
  if (panel.shown().isHidden || !whyNoTruth().empty()) return happened;
  return own->truth.follow(truthFrom(own->view), now) || happened;
}

WarpSettings Session::warpSettingsOf(size_t index) const {
  const Panel& shown = panel(index);
  const bool isChosen = shown.choice && shown.choice->technique == shown.technique;
  WarpSettings settings = isChosen ? shown.choice->warp(knobs_.warp) : knobs_.warp;
  for (const Knob* knob : shown.technique->knobs)
    if (knob->isOfPanel) settings.knobs.set(*knob, shown.knobs[*knob]);
  settings.knobs = settings.knobs.only(shown.technique->knobs);  // others' do not make it draw
  return settings;
}

bool Session::postJob(size_t index) {
  LivePanel& panel = panels_[index];
  const Panel& shown = panel.shown();
  if (shown.isHidden) return false;
  const LiveGroundTruth& truth = truthOf(panel);
  WarpJob job;
  job.technique = shown.technique;
  job.scene = sceneCount_;
  if (job.technique->usesFrame) {
    if (!frames_.newest()) return false;
    job.frame = frames_.newest();
  }
  job.reference = truth.image();
  job.marcher = opening_.current()->display;
  job.camera = viewOf(panel).cameraOfSize(pictureSize());
  job.settings = warpSettingsOf(index);
  job.settings.reference = truth.wanted().settings;
  job.background = scene()->background;
  job.marks = knobs_.marks;
  job.takesShortcuts = knobs_.takesShortcuts && job.technique->usesFrame;
  if (!panel.isNew(job)) return false;
  timing_.stop(panels_);
  panel.post(std::move(job));
  return true;
}

}  // namespace warpscope
