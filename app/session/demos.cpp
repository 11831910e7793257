// Five of them.
// See demos.h.
#include "app/session/demos.h"

#include <algorithm>
#include <utility>

#include "net/link_settings.h"
#include "render/base/named_value.h"

namespace warpscope {

std::span<const Demo> demos() {
  static const std::vector<Demo> kDemos{
      {"Satellite", "600 ms to a server: held pictures lag behind, segments follow the camera", "satellite", CameraMotion::orbit, {"hold", "segments"}, 192},
      {"Head movements", "A head that looks around over a telephone's network: turned pictures and points beside spheres and segments", "4g", CameraMotion::shake,
       {"rotate", "points", "spheres", "segments"}},
      {"Crowded hall", "Outages and little bandwidth while one flies through: what has been seen must do", "conference-wifi", CameraMotion::flyThrough,
       {"hold", "splats", "segments"}, 96},
      {"Nearer and farther", "Distances across an ocean: a mesh is stretched, points come apart, segments do neither", "transatlantic", CameraMotion::dolly,
       {"points", "mesh", "segments"}},
      {"One dot or a stretch", "A fast link, so that only the techniques differ: samples of the paper of 2020 beside segments and the truth", "home-fibre",
       CameraMotion::orbit, {"spheres", "segments", "reference"}},
  };
  return kDemos;
}

namespace {

void setUpPanels(const Demo& demo, Session& session) {
  while (session.panelCount() > demo.techniques.size()) session.removePanel(session.panelCount() - 1);
  for (size_t i = 0; i < demo.techniques.size(); ++i) {
    const WarpDescriptor& technique = findWarp(demo.techniques[i]);
    if (i >= session.panelCount()) session.addPanel({.technique = &technique});
    session.setTechnique(i, technique);
    session.setContent(i, PictureContent::picture);
    session.setOwnCamera(i, false);
  }
}

void setGoing(const Demo& demo, Session& session) {
  LiveSettings knobs = session.knobs();
  const auto presets = net::linkPresets();
  knobs.transport.link = std::ranges::find(presets, demo.link, &net::LinkPreset::name)->settings;
  knobs.transport.frameKib = demo.frameKib;
  knobs.isFrozen = false;
  session.setKnobs(knobs);
  session.setMotion(demo.motion);
}

/// Whether the newest frame has something for each panel.
bool isDrawable(const Session& session) {
  const SampleFramePtr& frame = session.frames().newest();
  if (frame == nullptr) return false;
  for (size_t i = 0; i < session.panelCount(); ++i) {
    const Panel& panel = session.panel(i);
    if (panel.technique->usesFrame && !lackOf(*panel.technique, frame->settings, panel.knobs).empty()) return false;
  }
  return true;
}

BeforeDemo beforeDemo(const Session& session) {
  BeforeDemo before{.panels = {}, .ownViews = {}, .view = session.view(), .scene = session.sceneCount(), .link = session.knobs().transport.link, .frameKib = session.knobs().transport.frameKib, .isFrozen = session.knobs().isFrozen};
  for (size_t i = 0; i < session.panelCount(); ++i) {
    before.panels.push_back(session.panel(i));
    before.ownViews.push_back(session.hasOwnCamera(i) ? std::optional(session.view(i)) : std::nullopt);
  }
  return before;
}

void endDemo(const BeforeDemo& before, Session& session) {
  session.setPanels(before.panels);
  session.setMotion(CameraMotion::none);
  const bool isSameScene = session.sceneCount() == before.scene;
  if (isSameScene)
    session.setView(before.view);
  else
    session.resetView();
  for (size_t i = 0; i < before.panels.size(); ++i) {
    session.setOwnCamera(i, before.ownViews[i].has_value());
    if (before.ownViews[i] && isSameScene) session.setView(i, *before.ownViews[i]);
  }
  LiveSettings knobs = session.knobs();
  knobs.transport.link = before.link;
  knobs.transport.frameKib = before.frameKib;
  knobs.isFrozen = before.isFrozen;
  session.setKnobs(knobs);
}

}  // namespace

void RunningDemo::start(const Demo& demo, Session& session, const EditHistory& history) {
  if (!before_ || scene_ != session.sceneCount()) depthBefore_ = history.depth();
  if (!before_) before_ = beforeDemo(session);
  scene_ = session.sceneCount();
  session.setMotion(CameraMotion::none);
  setUpPanels(demo, session);
  session.resetView();
  LiveSettings knobs = session.knobs();
  knobs.transport.link = {};
  knobs.isFrozen = false;
  session.setKnobs(knobs);
  pending_ = &demo;
  pendingView_ = session.view();
  pendingSince_.reset();
  depthBegun_.reset();
}

void RunningDemo::follow(Session& session, const EditHistory& history, bool isHeld, Session::TimePoint now) {
  if (!isOn() || isHeld) return;
  if (!depthBegun_) depthBegun_ = history.depth();
  if (pending_ == nullptr) return;
  if (!pendingSince_) pendingSince_ = now;
  if (session.sceneCount() != scene_ || history.depth() != *depthBegun_ || session.view() != pendingView_) {
    pending_ = nullptr;
  } else if (isDrawable(session) || now - *pendingSince_ > kPatience) {
    setGoing(*std::exchange(pending_, nullptr), session);
    depthBegun_.reset();
  }
}

bool RunningDemo::isLast(const Session& session, const EditHistory& history) const {
  return isOn() && session.sceneCount() == scene_ && (!depthBegun_ || history.depth() == *depthBegun_);
}

void RunningDemo::end(Session& session, EditHistory& history) {
  const bool isWhole = isLast(session, history);
  endDemo(*before_, session);
  if (isWhole) history.cutTo(depthBefore_);
  forget();
}

}  // namespace warpscope
