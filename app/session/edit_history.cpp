// Names of what differs, and two stacks.
// See edit_history.h.
#include "app/session/edit_history.h"

#include <algorithm>
#include <utility>

#include "app/frames/transport_knobs.h"
#include "app/session/picture_plan.h"
#include "render/march/march_knobs.h"

namespace warpscope {
namespace {

std::string changeBetween(const PanelSettings& before, const PanelSettings& after) {
  if (before.isAutomatic != after.isAutomatic || (!after.isAutomatic && before.technique != after.technique)) return "technique";
  if (!after.isAutomatic)
    for (const Knob* knob : warpKnobs())
      if (knob->isOfPanel && before.knobs[*knob] != after.knobs[*knob]) return std::string(knob->label);
  if (before.content != after.content) return "content";
  if (before.contentRange != after.contentRange) return "range of the content";
  return "";
}

template <class Rows, class Settings>
std::string changeAmong(const Rows& rows, const Settings& before, const Settings& after) {
  for (const auto& row : rows)
    if (row.get(before) != row.get(after)) return std::string(row.knob->label);
  return "";
}

std::string changeBetween(const LiveSettings& before, const LiveSettings& after) {
  if (before == after) return "";
  if (std::string change = changeAmong(marchKnobs(), before.march, after.march); !change.empty()) return change;
  for (const MarchText& text : marchTexts())
    if (text.get(before.march) != text.get(after.march)) return std::string(text.label);
  if (std::string change = changeAmong(transportKnobs(), before.transport, after.transport); !change.empty()) return change;
  for (const Knob* knob : warpKnobs())
    if (before.warp.knobs[*knob] != after.warp.knobs[*knob]) return std::string(knob->label);
  if (before.serverSidePx != after.serverSidePx) return std::string(kServerSideKnob.label);
  if (before.takesShortcuts != after.takesShortcuts) return std::string(kShortcutsKnob.label);
  if (before.screenPixels != after.screenPixels) return "pixel size";
  if (!(before.marks == after.marks)) return "marks";
  if (before.budgetMs != after.budgetMs) return "budget";
  if (!(before.transport.link == after.transport.link)) return "link";
  LiveSettings same = before;
  same.isFrozen = after.isFrozen;
  return same == after ? "" : "settings";
}

EditState stateOf(const Session& session, const TransferCurves* curves) {
  EditState state{session.knobs(), {}, curves != nullptr ? std::optional(*curves) : std::nullopt};
  for (size_t i = 0; i < session.panelCount(); ++i) {
    state.panels.push_back(session.panel(i));
    state.panelIds.push_back(session.panel(i).id);
  }
  return state;
}

}  // namespace

std::string changeBetween(const EditState& before, const EditState& after) {
  if (before.curves && after.curves && !(*before.curves == *after.curves)) return "transfer function";
  if (before.panelIds.size() != after.panelIds.size()) return "panels";
  if (before.panelIds != after.panelIds) return std::ranges::is_permutation(before.panelIds, after.panelIds) ? "order of the panels" : "panels";
  for (size_t i = 0; i < before.panels.size(); ++i)
    if (const std::string change = changeBetween(before.panels[i], after.panels[i]); !change.empty())
      return change + " of panel " + std::to_string(i + 1);
  return changeBetween(before.knobs, after.knobs);
}

void apply(const EditState& state, Session& session) {
  LiveSettings knobs = state.knobs;
  knobs.isFrozen = session.knobs().isFrozen;
  session.setKnobs(knobs);
  std::vector<PanelSettings> panels = state.panels;
  for (size_t i = 0; i < panels.size(); ++i)
    for (size_t now = 0; now < session.panelCount(); ++now)
      if (session.panel(now).id == state.panelIds[i]) panels[i].isHidden = session.panel(now).isHidden;
  session.setPanels(panels, state.panelIds);
}

void EditHistory::follow(const Session& session, const TransferCurves* curves, bool isHeld) {
  if (std::exchange(scene_, session.sceneCount()) != session.sceneCount()) {
    last_.reset();
    forgotten_ += done_.size();
    done_.clear();
    undone_.clear();
  }
  if (last_ && isHeld && !isTaken_) return;
  EditState now = stateOf(session, curves);
  std::string change = last_ && !std::exchange(isTaken_, false) ? changeBetween(*last_, now) : std::string();
  if (!change.empty()) {
    undone_.clear();
    done_.push_back({std::move(*last_), std::move(change)});
    if (done_.size() > kMost) {
      done_.erase(done_.begin());
      ++forgotten_;
    }
  }
  last_ = std::move(now);
}

void EditHistory::cutTo(uint64_t depth) {
  while (!done_.empty() && this->depth() > depth) done_.pop_back();
  undone_.clear();
  isTaken_ = true;
}

std::optional<EditState> EditHistory::step(std::vector<Step>& from, std::vector<Step>& to) {
  if (from.empty()) return std::nullopt;
  Step taken = std::move(from.back());
  from.pop_back();
  to.push_back({std::move(*last_), std::move(taken.change)});
  last_ = std::move(taken.state);
  isTaken_ = true;
  return last_;
}

}  // namespace warpscope
