// What the window can be told to do by a key or from its menus: one row each. Menus, the list of keys, what keys do and the reference are made from it.
// Plain data; app/ui/main_view.h does it.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace warpscope {

enum class Action {
  open,
  saveSession,
  restoreLast,
  copyCommand,
  savePicture,
  savePanels,
  savePlot,
  record,
  exportFilm,
  closeRecording,
  quit,
  resetView,
  freeze,
  play,
  stepBack,
  stepOn,
  ownCamera,
  showContent,
  showReference,
  blink,
  wipe,
  inspect,
  copyPixel,
  chooseTechnique,
  chooseAutomatic,
  addPanel,
  closePanel,
  maximise,
  goBack,
  showPlan,
  searchKnob,
  undo,
  redo,
  hideSideBar,
  lightTheme,
  fullScreen,
  help,
  about,
};

enum class ActionMenu { file, edit, view, panel, help, none };

/// One row of windowActions().
struct ActionDescriptor {
  Action action;
  ActionMenu menu;
  std::string_view label;  ///< in the menu: "Freeze"
  std::string_view keys;   ///< as one reads them, several parted by " or ": "Ctrl+Q", "Shift", "1 to 9"
  std::string_view help;   ///< what it does: one sentence without its full stop
  bool isHeld = false;     ///< while the key is down, not when it goes down
  bool isOfPanel = false;  ///< of the panel under the pointer or, from a menu, of the one that was used last
};

std::span<const ActionDescriptor> windowActions();
const ActionDescriptor& describe(Action action);

/// A key as its user sees it: one of "A" to "Z", "0" to "9", "?", "+", ",", ".", "Esc", "Tab", "Enter", "Space", "Delete", "F1" to "F12", "Shift"; with what was held.
struct KeyChord {
  std::string name{};
  bool isControl = false, isShift = false, isAlt = false;
};

/// One key of a row's `keys`, which several keys may have; "1 to 9" is none. Shift counts for letters, digits and named keys; characters such as ? need it on
/// some keyboards and not on others.
std::vector<KeyChord> chordsOf(const ActionDescriptor& action);

/// What a pressed key does; nothing for those that do nothing. Held keys are not asked for here. Digits from 1 on are Action::chooseTechnique.
std::optional<Action> actionOf(const KeyChord& pressed);

}  // namespace warpscope
