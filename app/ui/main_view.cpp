// Where everything stands, and what actions do.
// See main_view.h.
#include "app/ui/main_view.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>

#include "app/picture/picture.h"
#include "app/picture/plot_picture.h"
#include "app/picture/svg_plot.h"
#include "app/session/demos.h"
#include "app/shell/user_folders.h"
#include "app/ui/ground.h"
#include "app/ui/help_pages.h"
#include "app/ui/playback_bar.h"
#include "app/ui/ray_view.h"
#include "render/base/error.h"
#include "render/base/printable.h"

namespace warpscope::ui {
namespace {

constexpr float kControlsWidth = 268.0f, kStatusHeight = 28.0f, kMargin = 8.0f, kLeastForBothPx = 620.0f, kLeastPicturePx = 60.0f, kRayPx = 200.0f;  // at scale 1

constexpr float kSavedPlotScale = 2.0f;

/// From the picture to what was shown in its place last, and back.
void toggleContent(Session& session, size_t index) {
  const Panel& panel = session.panel(index);
  session.setContent(index, panel.content == PictureContent::picture ? panel.lastContent : PictureContent::picture, panel.contentRange);
}

void toggleFrozen(Session& session) {
  LiveSettings knobs = session.knobs();
  knobs.isFrozen = !knobs.isFrozen;
  session.setKnobs(knobs);
}

}  // namespace

MainView::MainView(const WindowGl& gl, const SceneOpener& openScene, std::optional<SweepFile> sweep, Remembered& remembered, std::function<void()> onNews)
    : gl_(gl), grid_(gl), plot_(std::move(sweep)), openScene_(openScene), remembered_(remembered), handedFiles_(onNews), files_(remembered, std::move(onNews)) {}

void MainView::takeHandedFiles(Session& session) {
  while (std::optional<HandedFile> file = handedFiles_.tryTake(!session.loading().empty())) take(std::move(*file), session);
}

void MainView::take(HandedFile file, Session& session) {
  if (!file.error.empty()) {
    setNote(file.error);
    plot_.showError(std::move(file.error));
  } else if (file.sweep) {
    remembered_.addFile(file.path);
    session.setFront(file.sweep->choice);
    plot_.showSweep(std::move(*file.sweep));
    remembered_.setFolded(PlotView::kHeading, false);
  } else if (file.transferFunction) {
    remembered_.addFile(file.path);
    controls_.transferEditor().set(session, *file.transferFunction);
  } else if (file.session) {
    if (std::filesystem::path(file.path) != lastSessionFile()) remembered_.addFile(file.path);
    keepForLater(session);
    restoreSession(*file.session, session);
  } else {
    keepForLater(session);
    session.load(openScene_({file.path, {}}));
  }
}

void MainView::keepForLater(const Session& session) {
  if (session.playback().isOpen()) return;
  beforeRecording_.reset();
  try {
    if (session.scene() != nullptr) beforeRecording_ = sessionFileOf(session);
  } catch (const InputError&) {
    // It cannot be opened again: the way back is to the first scene.
  }
}

void MainView::restoreSession(const SessionFile& file, Session& session) {
  isSessionsScene_ = true;
  restore(file, session, openScene_);
  demo_.forget();
  grid_.showAll();
}

bool MainView::mayClose(const Session& session) {
  if (!session.exporting().isAtWork() || quitQuestion_.isOpen()) return true;
  quitQuestion_.ask();
  return false;
}

void MainView::press(const KeyChord& key, Session& session) {
  const std::optional<Action> action = actionOf(key);
  if (!action) return;
  // What fields do themselves with Ctrl is theirs, too, while they are typed into.
  constexpr std::string_view kOfFields = "ACVXYZ";
  const bool isOfFields = key.name.size() == 1 && kOfFields.find(key.name[0]) != std::string_view::npos;
  const bool isTyped = (ImGui::GetIO().WantTextInput || typeAhead_.isWaiting()) && (!key.isControl || isOfFields);
  const bool hasPopup = ImGui::IsPopupOpen(nullptr, ImGuiPopupFlags_AnyPopup);
  if (*action == Action::goBack && hasPopup) {
    quitQuestion_.dismiss();
    return ImGui::SetWindowFocus(nullptr);  // closes them
  }
  if (*action == Action::goBack && dialog_.isOpen()) return dialog_.close();
  if (isTyped || ((hasPopup || dialog_.isOpen()) && *action != Action::quit)) return;
  perform(*action, session, grid_.underPointer(session), *action == Action::chooseTechnique ? static_cast<size_t>(key.name[0] - '0') : 0);
}

void MainView::showDialog(FileDialog::Purpose purpose, const std::string& name) {
  dialog_.show(purpose, name);
  if (dialog_.isOpen()) typeAhead_.begin();
}

void MainView::savePicture(Image<Rgba8> picture) {
  files_.keep({{".png", [picture = std::make_shared<const Image<Rgba8>>(std::move(picture))] { return encodePng(*picture); }}});
}

void MainView::savePlot(const Session& session) {
  const auto plot = std::make_shared<const Plot>(plot_.plot(session));
  files_.keep({{".png", [plot] { return encodePng(pictureOf(*plot, kSavedPlotScale)); }}, {".svg", [plot] { return svgFileOf(*plot); }}, {".csv", [csv = plot_.csv(session)] { return csv; }}});
}

void MainView::goBack() {
  if (showsKeys_ || showsAbout_)
    showsKeys_ = showsAbout_ = false;
  else if (!controls_.endSearch() && !grid_.goBack())
    windowActions_.push_back(Action::goBack);
}

void MainView::takeBack(Action action, Session& session) {
  TransferEditor& editor = controls_.transferEditor();
  if (editor.isHeld()) return;
  history_.follow(session, editor.curves(session), false);  // what was changed since the last frame
  const bool isUndo = action == Action::undo;
  if (isUndo && demo_.isLast(session, history_)) {
    endDemo(session);
    return setNote("taken back: the demo");
  }
  const std::string what = isUndo ? history_.undoes() : history_.redoes();
  const std::optional<EditState> state = isUndo ? history_.undo() : history_.redo();
  if (!state) return;
  apply(*state, session);
  if (state->curves) editor.setCurves(session, *state->curves);
  setNote((isUndo ? "taken back: " : "made again: ") + what);
}

void MainView::perform(Action action, Session& session, std::optional<size_t> panel, size_t number) {
  if (describe(action).isOfPanel && !panel) {
    if (action == Action::resetView) session.resetView();
    return;
  }
  switch (action) {
    case Action::open: return showDialog(FileDialog::Purpose::open);
    case Action::saveSession: return showDialog(FileDialog::Purpose::saveSession, "session.json");
    case Action::restoreLast:
      if (const auto last = lastSession()) open(last->string());
      return;
    case Action::copyCommand:
      try {
        const std::string command = commandLineOf(session);
        ImGui::SetClipboardText(command.c_str());
        setNote("copied: " + command);
      } catch (const InputError& error) {
        setNote(error.what());
      }
      return;
    case Action::record:
      if (session.isRecording()) return setNote(files_.endRecording(session));
      return showDialog(FileDialog::Purpose::record, "recording.warpscope");
    case Action::exportFilm:
      if (session.exporting().isAtWork()) {
        session.exporting().cancel();
        return setNote("the export was given up, nothing is left of it");
      }
      if (!isPossible(action, session)) return setNote("a film is made of a recording: open one, or record one (Ctrl+R)");
      return exportQuestion_.ask();
    case Action::closeRecording:
      if (!session.playback().isOpen()) return;
      if (beforeRecording_) return restoreSession(*beforeRecording_, session);
      return session.load(openScene_({std::string(kDefaultScene), {}}));
    case Action::savePanels:
      if (!files_.keepPanels(session)) setNote("there is no picture yet");
      return;
    case Action::savePlot: return savePlot(session);
    case Action::quit:
      if (mayClose(session)) windowActions_.push_back(action);
      return;
    case Action::savePicture:
    case Action::fullScreen: return windowActions_.push_back(action);
    case Action::goBack: return goBack();
    case Action::help: showsKeys_ = !showsKeys_; return;
    case Action::about: showsAbout_ = !showsAbout_; return;
    case Action::resetView: return session.resetView(*panel);
    case Action::freeze: return toggleFrozen(session);
    case Action::play: return session.playback().setPlaying(!session.playback().isPlaying());
    case Action::stepBack: return session.playback().step(-1);
    case Action::stepOn: return session.playback().step(1);
    case Action::ownCamera: return session.setOwnCamera(*panel, !session.hasOwnCamera(*panel));
    case Action::showContent: return toggleContent(session, *panel);
    case Action::wipe: return grid_.toggleWipe(session, *panel);
    case Action::inspect: return grid_.setInspecting(!grid_.isInspecting());
    case Action::copyPixel:
      if (const std::string text = grid_.textAboutPixel(session); !text.empty()) ImGui::SetClipboardText(text.c_str());
      return;
    case Action::chooseTechnique:
      if (number >= 1 && number <= warpRegistry().size()) session.setTechnique(*panel, warpRegistry()[number - 1]);
      return;
    case Action::chooseAutomatic: return session.setAutomatic(*panel);
    case Action::addPanel:
      if (!isPossible(action, session)) setNote(std::to_string(kMaxPanels) + " panels are the most");
      return grid_.addPanel(session);
    case Action::closePanel: return grid_.closePanel(session, *panel);
    case Action::maximise: return grid_.toggleMaximised(session, *panel);
    case Action::showPlan: return session.setShowsPlan(!session.showsPlan());
    case Action::searchKnob:
      remembered_.hasSideBar = true;
      controls_.search();
      return typeAhead_.begin();
    case Action::undo:
    case Action::redo: return takeBack(action, session);
    case Action::hideSideBar: remembered_.hasSideBar = !remembered_.hasSideBar; return;
    case Action::lightTheme: remembered_.isLight = !remembered_.isLight; return;
    case Action::showReference:
    case Action::blink: return;  // as long as their keys are down
  }
}

void MainView::start(const Demo& demo, Session& session) {
  demo_.start(demo, session, history_);
  grid_.showAll();
  setNote("Demo: " + std::string(demo.name) + ". " + std::string(demo.summary) + ". Drag to stop the camera; Demo > End the demo goes back to what was.");
}

void MainView::endDemo(Session& session) {
  demo_.end(session, history_);
  grid_.showAll();
}

void MainView::drawDialog(Session& session, const Look& look) {
  if (const auto wish = controls_.transferEditor().takeFileWish()) {
    if (*wish == TransferEditor::FileWish::load) showDialog(FileDialog::Purpose::openFunction);
    if (*wish == TransferEditor::FileWish::save) showDialog(FileDialog::Purpose::saveFunction, "function.json");
    if (*wish == TransferEditor::FileWish::saveForParaview) showDialog(FileDialog::Purpose::saveColorMap, "colormap.json");
  }
  const std::optional<std::filesystem::path> path = dialog_.draw(look);
  if (!path) return;
  try {
    switch (dialog_.purpose()) {
      case FileDialog::Purpose::open:
      case FileDialog::Purpose::openFunction: return open(path->string());
      case FileDialog::Purpose::saveSession: return setNote(files_.saveSession(session, *path));
      case FileDialog::Purpose::record: return setNote(files_.startRecording(session, *path));
      case FileDialog::Purpose::exportFilm: return setNote(files_.startExport(session, *path, exportLook_));
      case FileDialog::Purpose::saveFunction:
      case FileDialog::Purpose::saveColorMap:
        if (session.scene() == nullptr) return;
        files_.requireUnread(session, *path);
        controls_.transferEditor().save(session, *path, dialog_.purpose() == FileDialog::Purpose::saveColorMap);
        return setNote("saved " + path->string());
    }
  } catch (const InputError& error) {
    dialog_.askAgain(error.what());
  }
}

void MainView::drawQuestions(const Session& session, const Look& look) {
  if (const std::optional<ExportLook> chosen = exportQuestion_.draw(session, look)) {
    exportLook_ = *chosen;
    showDialog(FileDialog::Purpose::exportFilm, canFilm() ? "film.mp4" : "film.png");
  }
  if (quitQuestion_.draw(session)) windowActions_.push_back(Action::quit);
}

void MainView::drawNote(const Look& look) {
  constexpr std::chrono::seconds kShown(7);
  if (note_.text.empty()) return;
  if (!note_.since) note_.since = look.now;
  if (look.now - *note_.since > kShown) return note_.text.clear();
  ImDrawList* list = ImGui::GetForegroundDrawList();
  const ImVec2 display = ImGui::GetIO().DisplaySize;
  const std::string text = printable(note_.text);
  const float wrap = 0.96f * display.x, padding = look.px(5.0f);
  const ImVec2 size = ImGui::CalcTextSize(text.c_str(), nullptr, false, wrap);
  // In the status bar's place: what is above is looked at.
  const ImVec2 at{0.5f * (display.x - size.x), display.y - size.y - padding};
  list->AddRectFilled({0.0f, std::min(at.y - padding, display.y - look.px(kStatusHeight))}, display, ImGui::GetColorU32({0.0f, 0.0f, 0.0f, 1.0f}));
  list->AddText(ImGui::GetFont(), ImGui::GetFontSize(), at, ImGui::GetColorU32(kTextOnPicture), text.c_str(), nullptr, wrap);
}

void MainView::drawBottom(Session& session, const Look& look) {
  ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {look.px(8.0f), look.px(8.0f)});
  ImGui::PushStyleVar(ImGuiStyleVar_ItemSpacing, {look.px(8.0f), look.px(6.0f)});
  const ImGuiWindowFlags flags = ImGuiWindowFlags_NoScrollbar | ImGuiWindowFlags_NoScrollWithMouse;
  const float room = ImGui::GetContentRegionAvail().x;
  const bool hasRay = session.lookedAt() && plot_.isUnfolded(), isShared = hasRay && room >= look.px(kLeastForBothPx);
  if (!hasRay || isShared) {
    beginChildOnGround(gl_, "plot", {isShared ? 0.45f * room : 0.0f, 0.0f}, flags);
    plot_.draw(session, grid_.usedLast(session), look);
    ImGui::EndChild();
  }
  if (isShared) ImGui::SameLine(0.0f, look.px(kMargin));
  if (hasRay) {
    beginChildOnGround(gl_, "ray", {0.0f, 0.0f}, flags);
    if (!drawRay(session, look)) session.lookAt(std::nullopt);
    ImGui::EndChild();
  }
  ImGui::PopStyleVar(2);
}

void MainView::drawBody(Session& session, const HeldKeys& held, const Look& look) {
  const float bodyHeight = std::max(1.0f, ImGui::GetContentRegionAvail().y - look.px(kStatusHeight));
  const float sideBar = remembered_.hasSideBar ? look.px(kControlsWidth + kMargin) : 0.0f;
  ImGui::PushStyleColor(ImGuiCol_ChildBg, {0.0f, 0.0f, 0.0f, 0.0f});
  ImGui::BeginChild("panels", {ImGui::GetContentRegionAvail().x - sideBar, bodyHeight}, false,
                    ImGuiWindowFlags_NoScrollbar | ImGuiWindowFlags_NoScrollWithMouse);
  ImGui::PopStyleColor();
  drawLinkSign(session, look);
  const ImVec2 top = ImGui::GetCursorPos();
  ImVec2 room = ImGui::GetContentRegionAvail();
  room.y -= playbackHeight(session, room.x, look);
  float bottom = plot_.height(room.y, look) + look.px(kMargin);
  // A ray is looked at in as much room as its curves and names need, as far as pictures stay large enough to be looked at.
  if (session.lookedAt() && plot_.isUnfolded())
    for (const float most = std::min(look.px(kRayPx), 0.5f * room.y), step = look.px(10.0f); bottom + step <= most; bottom += step)
      if (grid_.barePictureSide(session, {room.x, room.y - bottom - step}, look) < look.px(kLeastPicturePx)) break;
  // Where pictures would be too low, and where one is to be as large as can be, the plot gives way.
  const bool hasBottom = session.lookedAt() || (!grid_.isAlone() && grid_.pictureSide(session, {room.x, room.y - bottom}, look) >= look.px(kLeastPicturePx));
  room.y = std::max(1.0f, room.y - (hasBottom ? bottom : 0.0f));
  const std::optional<PanelGrid::Asked> asked = grid_.draw(session, room, held, look);
  // The ray that a loupe was held on goes with it.
  if (std::exchange(wasInspecting_, grid_.isInspecting()) && !grid_.isInspecting()) session.lookAt(std::nullopt);
  const bool wantsExport = drawPlayback(session, room.x, look);
  followedCamera_ = session.playback().isOpen() && session.playback().followsCamera();
  if (hasBottom) drawBottom(session, look);
  if (asked) perform(asked->action, session, session.placeOf(asked->panel));
  if (wantsExport) perform(Action::exportFilm, session);
  ImGui::SetCursorPosX(top.x);  // over what is there, which stays as it is
  drawErrorBanner(session, look);
  ImGui::EndChild();
  ImGui::PopStyleVar(2);
  if (remembered_.hasSideBar) {
    ImGui::SameLine(0.0f, look.px(kMargin));
    beginChildOnGround(gl_, "controls", {0.0f, bodyHeight});
    controls_.draw(session, openScene_, [&](const std::string& path) { open(path); }, history_, look);
    ImGui::EndChild();
  }
}

void MainView::rememberScene(const Session& session) {
  if (session.sceneCount() == sceneSeen_) return;
  sceneSeen_ = session.sceneCount();
  if (std::exchange(isSessionsScene_, false)) return;  // the session is what was opened
  std::error_code ignored;
  if (session.origin() && std::filesystem::exists(session.origin()->spec, ignored)) remembered_.addFile(session.origin()->spec);
}

void MainView::draw(Session& session, double displayFramesPerSecond, const HeldKeys& held, const Look& drawn) {
  Look look = drawn;
  look.remembered = &remembered_;
  look.gl = &gl_;
  applyColors(remembered_.isLight ? Theme::light : Theme::dark);
  typeAhead_.beginFrame();
  takeHandedFiles(session);
  rememberScene(session);
  // Not by its box, so by the hand on a picture.
  if (followedCamera_ && session.playback().isOpen() && !session.playback().followsCamera())
    setNote("The camera is yours now, frames come as they were recorded. Tick \"Recorded camera\" to follow it again.");
  if (std::optional<std::string> note = files_.takeNote(session)) setNote(std::move(*note));
  controls_.transferEditor().update(session, look.now);
  drawMenus(session, look);
  const float top = ImGui::GetFrameHeight();  // of the menu bar
  const ImVec2 display = ImGui::GetIO().DisplaySize;
  ImGui::SetNextWindowPos({0.0f, top});
  ImGui::SetNextWindowSize({display.x, std::max(1.0f, display.y - top)});
  ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {look.px(kMargin), look.px(kMargin)});
  ImGui::PushStyleVar(ImGuiStyleVar_ItemSpacing, {look.px(kMargin), look.px(kMargin)});
  ImGui::Begin("warpscope", nullptr,
               ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_NoBringToFrontOnFocus |
                   ImGuiWindowFlags_NoNav | ImGuiWindowFlags_NoScrollWithMouse | ImGuiWindowFlags_NoBackground);  // the window is cleared with that colour
  drawBody(session, held, look);
  ImGui::SetCursorPosY(ImGui::GetWindowHeight() - look.px(kStatusHeight));
  drawStatusBar(session, displayFramesPerSecond, look);
  ImGui::End();
  if (std::optional<std::string> note = controls_.transferEditor().takeNote()) setNote(std::move(*note));
  if (const std::optional<Action> action = controls_.transferEditor().takeAction()) perform(*action, session);
  const bool isHeld = ImGui::IsAnyItemActive() || ImGui::IsAnyMouseDown();
  history_.follow(session, controls_.transferEditor().curves(session), isHeld);
  demo_.follow(session, history_, isHeld, look.now);
  history_.setWhole(demo_.isLast(session, history_) ? "demo" : "");
  if (showsKeys_) drawKeysPage(showsKeys_, look);
  if (showsAbout_) drawAboutPage(showsAbout_, session, gl_.renderer, look);
  drawDialog(session, look);
  drawQuestions(session, look);
  drawNote(look);
}

}  // namespace warpscope::ui
