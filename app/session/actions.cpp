// The list, and how keys are read from it.
// See actions.h.
#include "app/session/actions.h"

#include <algorithm>
#include <array>
#include <cctype>

namespace warpscope {
namespace {

constexpr std::array<ActionDescriptor, 38> kActions{{
    {Action::open, ActionMenu::file, "Open...", "Ctrl+O", "A scene, a volume, a transfer function, a sweep, a session or a recording: also by dropping it onto the window"},
    {Action::saveSession, ActionMenu::file, "Save session...", "Ctrl+S", "The scene, its look, the camera, the panels and all knobs, in a file"},
    {Action::restoreLast, ActionMenu::file, "Last session", "", "What was on show when a window was closed last"},
    {Action::copyCommand, ActionMenu::file, "Copy command", "", "The command that shows the same: by options where they say all of it, else with the session's text"},
    {Action::savePicture, ActionMenu::file, "Save picture", "F12", "The window as a PNG file in the folder where the program was started"},
    {Action::savePanels, ActionMenu::file, "Save panels", "Shift+F12", "Each panel's picture as a PNG file, pixel for pixel as it was drawn, in that folder"},
    {Action::savePlot, ActionMenu::file, "Save plot", "", "The points of the plot as pictures (PNG, SVG) and as a CSV table, in that folder"},
    {Action::record, ActionMenu::file, "Record...", "Ctrl+R", "Frames and the camera into a file, which shows them again by any techniques when it is opened, as does `warpscope replay`; or end that"},
    {Action::exportFilm, ActionMenu::file, "Export film...", "Ctrl+E", "The recording on show as a film (MP4, GIF) or as numbered pictures, by the techniques on show; or give that up"},
    {Action::closeRecording, ActionMenu::file, "Close the recording", "", "Back to what the window showed before the recording was opened in it; to the first built-in scene where that was nothing"},
    {Action::quit, ActionMenu::file, "Quit", "Ctrl+Q", "Close the window"},
    {Action::resetView, ActionMenu::view, "First view", "R", "Back to the scene's first view", false, true},
    {Action::freeze, ActionMenu::view, "Freeze", "F", "Keep the frame on show and ask the server for no other"},
    {Action::play, ActionMenu::view, "Play the recording", "Space", "Let the recording that is on show go on, or stand still"},
    {Action::stepBack, ActionMenu::view, "A frame back", ",", "To the recording's frame before this one, and stay there"},
    {Action::stepOn, ActionMenu::view, "A frame on", ".", "To the recording's next frame, and stay there"},
    {Action::ownCamera, ActionMenu::panel, "Own camera", "C", "Turn this panel alone, or follow the others again; the server goes on seeing what the others see", false, true},
    {Action::showContent, ActionMenu::panel, "Content or picture", "H", "What was chosen last beside the technique, instead of its picture, and back", false, true},
    {Action::showReference, ActionMenu::none, "Ground truth", "Shift", "The ground truth, as long as the key is held", true, true},
    {Action::blink, ActionMenu::none, "Blink", "B", "In turns with the next panel's picture, as long as the key is held", true, true},
    {Action::wipe, ActionMenu::panel, "Wipe", "W", "This panel's picture on the left of a bar and the next one's on its right; drag the bar", false, true},
    {Action::inspect, ActionMenu::view, "Inspect pixels", "I", "A loupe in all panels, and what is known of the pixel under the pointer; a click looks along its ray"},
    {Action::copyPixel, ActionMenu::none, "Copy the pixel", "Ctrl+C", "What is known of the pixel under the pointer, as text", false, true},
    {Action::chooseTechnique, ActionMenu::none, "Technique", "1 to 9", "A technique, in the order of the list", false, true},
    {Action::chooseAutomatic, ActionMenu::none, "Auto", "0", "The panel chooses its technique by itself", false, true},
    {Action::addPanel, ActionMenu::panel, "Add a panel", "+", "One more panel, up to six; drag panels by their titles to arrange them"},
    {Action::closePanel, ActionMenu::panel, "Close", "Delete", "Close this panel, if it is not the only one", false, true},
    {Action::maximise, ActionMenu::panel, "Maximise", "Enter", "This panel alone, or all again; as a double click on its title", false, true},
    {Action::goBack, ActionMenu::none, "Back", "Esc", "Leave what is in front: a menu, a dialog, the list of keys, a search, a wipe, the loupe, a panel alone, the full screen"},
    {Action::showPlan, ActionMenu::view, "What a frame takes", "E", "The stages of the newest frame's march, and what each costs"},
    {Action::searchKnob, ActionMenu::edit, "Search a knob", "Ctrl+F", "Type a part of its name or of what it does"},
    {Action::undo, ActionMenu::edit, "Undo", "Ctrl+Z", "Take the last change of knobs, panels or the transfer function back"},
    {Action::redo, ActionMenu::edit, "Redo", "Ctrl+Shift+Z or Ctrl+Y", "Make again what was taken back"},
    {Action::hideSideBar, ActionMenu::view, "Side bar", "Tab", "The column of knobs, or more room for the pictures"},
    {Action::lightTheme, ActionMenu::view, "Light theme", "", "Dark text on a light ground, or light text on a dark one"},
    {Action::fullScreen, ActionMenu::view, "Full screen", "F11", "The window on the whole screen, or as it was"},
    {Action::help, ActionMenu::help, "Keys", "F1 or ?", "All keys"},
    {Action::about, ActionMenu::help, "About", "", "Which version this is, and what it runs on"},
}};

KeyChord chordOf(std::string_view text) {
  KeyChord chord;
  const auto takePrefix = [&](std::string_view prefix, bool& isThere) {
    if (!text.starts_with(prefix) || text.size() == prefix.size()) return;
    text.remove_prefix(prefix.size());
    isThere = true;
  };
  takePrefix("Ctrl+", chord.isControl);
  takePrefix("Alt+", chord.isAlt);
  takePrefix("Shift+", chord.isShift);
  chord.name = text;
  return chord;
}

/// Whether keyboards differ in how it is typed.
bool isSign(const std::string& name) { return name.size() == 1 && std::isalnum(static_cast<unsigned char>(name[0])) == 0; }

bool isPress(const KeyChord& pressed, const KeyChord& wanted) {
  return pressed.name == wanted.name && pressed.isControl == wanted.isControl && pressed.isAlt == wanted.isAlt &&
         (pressed.isShift == wanted.isShift || isSign(wanted.name));
}

}  // namespace

std::span<const ActionDescriptor> windowActions() { return kActions; }

const ActionDescriptor& describe(Action action) { return *std::ranges::find(kActions, action, &ActionDescriptor::action); }

std::vector<KeyChord> chordsOf(const ActionDescriptor& action) {
  std::vector<KeyChord> chords;
  if (action.action == Action::chooseTechnique) return chords;
  constexpr std::string_view kOr = " or ";
  std::string_view rest = action.keys;
  for (size_t at = rest.find(kOr); at != std::string_view::npos; at = rest.find(kOr)) {
    chords.push_back(chordOf(rest.substr(0, at)));
    rest.remove_prefix(at + kOr.size());
  }
  if (!rest.empty()) chords.push_back(chordOf(rest));
  return chords;
}

std::optional<Action> actionOf(const KeyChord& pressed) {
  const bool isDigit = pressed.name.size() == 1 && pressed.name[0] >= '1' && pressed.name[0] <= '9';
  if (isDigit && !pressed.isControl && !pressed.isAlt && !pressed.isShift) return Action::chooseTechnique;
  for (const ActionDescriptor& action : kActions) {
    if (action.isHeld) continue;
    for (const KeyChord& chord : chordsOf(action))
      if (isPress(pressed, chord)) return action.action;
  }
  return std::nullopt;
}

}  // namespace warpscope
