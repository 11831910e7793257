// All that the window shows, whatever it is drawn into: menus, panels, knobs, plot, status.
// Does what keys and menus ask for, but for what only a window can: that it hands on.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "app/session/actions.h"
#include "app/session/demos.h"
#include "app/session/handed_file.h"
#include "app/session/session_file.h"
#include "app/ui/controls.h"
#include "app/ui/file_dialog.h"
#include "app/ui/kept_files.h"
#include "app/ui/panel_grid.h"
#include "app/ui/parts.h"
#include "app/ui/plot_view.h"
#include "app/ui/questions.h"
#include "app/ui/type_ahead.h"

namespace warpscope::ui {

class MainView {
 public:
  /// `gl`, `openScene` and `remembered` outlive it; `onNews` is called on another thread when a file that was handed over has been looked at.
  MainView(const WindowGl& gl, const SceneOpener& openScene, std::optional<SweepFile> sweep, Remembered& remembered, std::function<void()> onNews);

  /// Files are chosen by the desktop's dialogs from now on, where there are some.
  void useDesktopDialogs(std::function<void()> onNews) { dialog_.useDesktop(std::move(onNews)); }
  /// A transfer function's file that is loaded whenever it is written.
  void watchTransferFile(const std::filesystem::path& path, std::function<void()> onNews) { controls_.transferEditor().watch(path, std::move(onNews)); }
  /// Files that the user handed over together, whatever they are (handed_file.h); they are there some frames later.
  void open(std::vector<std::string> paths) { handedFiles_.hand(std::move(paths)); }
  void open(const std::string& path) { open(std::vector{path}); }
  /// What a pressed key does. Keys that are typed into a field are the field's.
  void press(const KeyChord& key, Session& session);
  /// What a menu's entry does; of panels it means the one that was used last.
  void perform(Action action, Session& session) { perform(action, session, grid_.usedLast(session)); }
  /// Within a frame of Dear ImGui, over all of its display.
  void draw(Session& session, double displayFramesPerSecond, const HeldKeys& held, const Look& look);

  bool showsKeys() const { return showsKeys_; }
  bool showsAbout() const { return showsAbout_; }
  bool showsDialog() const { return dialog_.isOpen(); }
  /// What is typed into the field in which knobs are searched.
  std::string_view searched() const { return controls_.searched(); }
  size_t foundKnobs() const { return controls_.foundKnobs(); }
  const TransferEditor& transferEditor() const { return controls_.transferEditor(); }

  /// Shows a demonstration; the menu ends it.
  void start(const Demo& demo, Session& session);

  /// Writes the window's picture into a file of the next free number.
  void savePicture(Image<Rgba8> picture);

  /// A recording was begun elsewhere than by its menu.
  void noteRecording(const std::filesystem::path& path) { files_.noteRecording(path); }

  /// Something to be said at the bottom of the window, for some seconds.
  void setNote(std::string note) { note_ = {std::move(note), {}}; }

  /// The last that was said, for as long as it is.
  const std::string& note() const { return note_.text; }

  /// What was asked for since the last call that is the window's business: quit, fullScreen, savePicture, and goBack where there was nothing to go back from.
  std::vector<Action> takeWindowActions() { return std::exchange(windowActions_, {}); }
  /// Whether the window may be closed now; else the user is asked, and quit comes among those actions where the answer is yes. Who asks for it again has answered.
  bool mayClose(const Session& session);
  /// Whether something moves although nothing happens.
  bool isAnimating() const { return grid_.isAnimating(); }

 private:
  void takeHandedFiles(Session& session);
  void take(HandedFile file, Session& session);
  /// `number`: of a technique, from 1 on. `panel`: of those that an action is about.
  void perform(Action action, Session& session, std::optional<size_t> panel, size_t number = 0);
  void goBack();
  /// Undo or redo.
  void takeBack(Action action, Session& session);
  void savePlot(const Session& session);
  /// In menus: with what would be taken back.
  std::string labelOf(const ActionDescriptor& action, const Session& session) const;
  bool isPossible(Action action, const Session& session) const;
  bool isOn(Action action, const Session& session, size_t panel) const;
  void drawMenus(Session& session, const Look& look);
  void drawRecent();
  void rememberScene(const Session& session);
  void endDemo(Session& session);
  void drawDemos(Session& session, const Look& look);
  void drawMenu(ActionMenu menu, const char* name, Session& session);
  void drawBody(Session& session, const HeldKeys& held, const Look& look);
  /// The plot, and the ray that is looked at.
  void drawBottom(Session& session, const Look& look);
  void drawDialog(Session& session, const Look& look);
  void drawQuestions(const Session& session, const Look& look);
  /// What is on show, unless that is a recording, so that closeRecording comes back to it.
  void keepForLater(const Session& session);
  void restoreSession(const SessionFile& file, Session& session);
  void drawNote(const Look& look);
  void showDialog(FileDialog::Purpose purpose, const std::string& name = "");

  const WindowGl& gl_;
  Controls controls_;
  EditHistory history_;
  PanelGrid grid_;
  PlotView plot_;
  const SceneOpener& openScene_;
  Remembered& remembered_;
  HandedFiles handedFiles_;
  uint64_t sceneSeen_ = 0;  // that was remembered last, as Session::sceneCount()
  KeptFiles files_;
  std::vector<Action> windowActions_;
  bool showsKeys_ = false, showsAbout_ = false;
  FileDialog dialog_;
  ExportQuestion exportQuestion_;
  ExportLook exportLook_;  // that was chosen
  QuitQuestion quitQuestion_;
  TypeAhead typeAhead_;
  bool isSessionsScene_ = false;        // what is being opened
  bool wasInspecting_ = false;
  bool followedCamera_ = false;  // that of a recording
  std::optional<SessionFile> beforeRecording_;  // what was on show, not being one, when a session or a recording was opened here
  RunningDemo demo_;
  struct Note {
    std::string text;
    std::optional<Session::TimePoint> since;
  };
  Note note_;
};

}  // namespace warpscope::ui
