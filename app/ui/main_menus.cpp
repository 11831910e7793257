// What the menus have: a row for each action, files that were opened, columns, demonstrations.
// See main_view.h.
#include <filesystem>

#include "app/session/demos.h"
#include "app/shell/user_folders.h"
#include "app/ui/main_view.h"
#include "render/base/printable.h"

namespace warpscope::ui {

bool MainView::isOn(Action action, const Session& session, size_t panel) const {
  switch (action) {
    case Action::freeze: return session.knobs().isFrozen;
    case Action::play: return session.playback().isPlaying();
    case Action::ownCamera: return session.hasOwnCamera(panel);
    case Action::showContent: return session.panel(panel).content != PictureContent::picture;
    case Action::wipe: return grid_.isWiped(session, panel);
    case Action::inspect: return grid_.isInspecting();
    case Action::maximise: return grid_.isMaximised(session, panel);
    case Action::showPlan: return session.showsPlan();
    case Action::exportFilm: return session.exporting().isAtWork();
    case Action::hideSideBar: return remembered_.hasSideBar;
    case Action::lightTheme: return remembered_.isLight;
    default: return false;
  }
}

bool MainView::isPossible(Action action, const Session& session) const {
  switch (action) {
    case Action::restoreLast: return lastSession().has_value();
    case Action::undo: return !history_.undoes().empty();
    case Action::redo: return !history_.redoes().empty();
    case Action::addPanel: return session.panelCount() < kMaxPanels;
    case Action::closePanel:
    case Action::wipe:
    case Action::maximise: return session.panelCount() > 1;
    case Action::play:
    case Action::stepBack:
    case Action::stepOn: return session.playback().isOpen();
    case Action::exportFilm: return session.playback().isOpen() || session.exporting().isAtWork();
    case Action::closeRecording: return session.playback().isOpen();
    case Action::freeze: return !session.playback().isOpen();
    default: return true;
  }
}

std::string MainView::labelOf(const ActionDescriptor& action, const Session& session) const {
  if (action.action == Action::exportFilm && session.exporting().isAtWork()) return "Cancel the export";
  if (action.action == Action::record && session.isRecording()) return "End the recording";
  const std::string what = action.action == Action::undo ? history_.undoes() : action.action == Action::redo ? history_.redoes() : std::string();
  return std::string(action.label) + (what.empty() ? "" : ": " + what);
}

void MainView::drawMenu(ActionMenu menu, const char* name, Session& session) {
  if (!ImGui::BeginMenu(name)) return;
  const size_t panel = grid_.usedLast(session);
  if (menu == ActionMenu::panel) ImGui::TextDisabled("Panel %zu: %s", panel + 1, std::string(session.panel(panel).technique->label).c_str());
  std::optional<Action> chosen;  // done when all entries are drawn: it may close the panel
  for (const ActionDescriptor& action : windowActions()) {
    if (action.menu != menu) continue;
    if (ImGui::MenuItem(labelOf(action, session).c_str(), std::string(action.keys).c_str(), isOn(action.action, session, panel), isPossible(action.action, session)))
      chosen = action.action;
    if (action.action == Action::open) drawRecent();
  }
  if (menu == ActionMenu::view && ImGui::BeginMenu("Columns")) {
    if (ImGui::MenuItem("As many as fit", nullptr, grid_.columns() == 0)) grid_.setColumns(0);
    for (size_t columns = 1; columns <= kMaxPanels; ++columns)
      if (ImGui::MenuItem(std::to_string(columns).c_str(), nullptr, grid_.columns() == columns)) grid_.setColumns(columns);
    ImGui::EndMenu();
  }
  ImGui::EndMenu();
  if (chosen) perform(*chosen, session, panel);
}

void MainView::drawRecent() {
  if (!ImGui::BeginMenu("Open again", !remembered_.recentFiles.empty())) return;
  std::optional<std::string> chosen;  // done when all are drawn: it moves them
  for (const std::string& file : remembered_.recentFiles)
    if (ImGui::MenuItem((printable(file) + "##" + file).c_str())) chosen = file;
  ImGui::Separator();
  const bool isToForget = ImGui::MenuItem("Forget these");
  ImGui::EndMenu();
  if (chosen) open(*chosen);
  if (isToForget) remembered_.recentFiles.clear();
}

void MainView::drawDemos(Session& session, const Look& look) {
  if (!ImGui::BeginMenu("Demo")) return;
  for (const Demo& demo : demos()) {
    if (ImGui::MenuItem(std::string(demo.name).c_str(), nullptr, false, session.scene() != nullptr)) start(demo, session);
    tooltip(std::string(demo.summary) + ".", look);
  }
  ImGui::Separator();
  const bool isMoving = session.motion().motion() != CameraMotion::none;
  if (ImGui::MenuItem("Stop the camera", nullptr, false, isMoving)) session.setMotion(CameraMotion::none);
  if (ImGui::MenuItem("End the demo", nullptr, false, demo_.isOn())) endDemo(session);
  tooltip("Panels, link and camera as they were before the first one.", look);
  ImGui::EndMenu();
}

void MainView::drawMenus(Session& session, const Look& look) {
  ImGui::PushStyleColor(ImGuiCol_WindowBg, {0.0f, 0.0f, 0.0f, 0.0f});  // beneath the bar's own ground
  const bool isOpen = ImGui::BeginMainMenuBar();
  ImGui::PopStyleColor();
  if (!isOpen) return;
  drawMenu(ActionMenu::file, "File", session);
  drawMenu(ActionMenu::edit, "Edit", session);
  drawMenu(ActionMenu::view, "View", session);
  drawMenu(ActionMenu::panel, "Panel", session);
  drawDemos(session, look);
  drawMenu(ActionMenu::help, "Help", session);
  ImGui::EndMainMenuBar();
}

}  // namespace warpscope::ui
