// What a hand has set in the window, step by step, so that it can be taken back: knobs, panels, the transfer function.
// Found by looking at the session once a frame, so that no widget has to tell of it. Cameras, what is measured and what is on show alone or folded are not in it.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "app/scene/transfer_curves.h"
#include "app/session/session.h"

namespace warpscope {

struct EditState {
  LiveSettings knobs;
  std::vector<PanelSettings> panels;
  std::optional<TransferCurves> curves;  ///< nothing where the function is not the user's to choose
  std::vector<uint64_t> panelIds{};      ///< which panels they are
};

/// What differs, by the name that it has in the window; empty where nothing does that a hand could have set: what panels that choose by themselves have chosen, whether the server is frozen and
/// which panels are hidden is none of that. Of several differences the first.
std::string changeBetween(const EditState& before, const EditState& after);

/// Knobs and panels as they were; the curves are whoever's who edits them.
void apply(const EditState& state, Session& session);

class EditHistory {
 public:
  static constexpr size_t kMost = 200;  ///< steps

  /// Once for each frame. `curves` of what is on show, null where they are not the user's to choose; while something `isHeld`, whatever changes is one step that has not ended.
  /// Another scene begins anew.
  void follow(const Session& session, const TransferCurves* curves, bool isHeld);

  /// What would be taken back or made again, as changeBetween() names it; empty: nothing.
  std::string undoes() const { return !whole_.empty() ? whole_ : done_.empty() ? std::string() : done_.back().change; }
  std::string redoes() const { return undone_.empty() ? std::string() : undone_.back().change; }

  /// How many steps lie behind what is on show, those that are forgotten included.
  uint64_t depth() const { return forgotten_ + done_.size(); }
  /// What somebody else took back is no step, and the steps that lie beyond that depth are gone.
  void cutTo(uint64_t depth);
  /// Steps that somebody else takes back together, by their name; empty: there are none now.
  void setWhole(std::string name) { whole_ = std::move(name); }

  /// What is to be shown from now on, if there is anything; whatever follow() sees then is no step of its own.
  std::optional<EditState> undo() { return step(done_, undone_); }
  std::optional<EditState> redo() { return step(undone_, done_); }

 private:
  struct Step {
    EditState state;
    std::string change;  ///< between that and its neighbour towards now
  };
  std::optional<EditState> step(std::vector<Step>& from, std::vector<Step>& to);

  uint64_t scene_ = 0;  // as Session::sceneCount()
  std::optional<EditState> last_;
  std::vector<Step> done_, undone_;  // the nearest to now last
  uint64_t forgotten_ = 0;
  std::string whole_;
  bool isTaken_ = false;  // undo() or redo() was called since follow()
};

}  // namespace warpscope
