// The window's main loop: events, session, panels, picture.
// See run_window.h.
#include "app/ui/run_window.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "app/picture/picture.h"
#include "app/session/demos.h"
#include "app/session/recorded_scene.h"
#include "app/session/remembered.h"
#include "app/session/window_report.h"
#include "app/shell/log.h"
#include "app/shell/output_files.h"
#include "app/shell/user_folders.h"
#include "app/ui/main_view.h"
#include "app/ui/window.h"
#include "render/base/abandonable.h"

namespace warpscope {
namespace ui {
namespace {

/// For threads to end, and for leaving a server far away.
constexpr std::chrono::milliseconds kClosingPatience(900);
/// After the last event the display keeps its rate for this long.
constexpr std::chrono::milliseconds kLinger(500);

/// What the user asked of the window. False if it is to be closed.
bool perform(Window& window, const std::vector<Action>& asked, bool& wantsPicture) {
  for (const Action action : asked) {
    if (action == Action::quit) return false;
    if (action == Action::fullScreen) window.setFullScreen(!window.isFullScreen());
    if (action == Action::goBack) window.setFullScreen(false);
    if (action == Action::savePicture) wantsPicture = true;
  }
  return true;
}

void keep(const Remembered& remembered) {
  const std::optional<std::filesystem::path> file = rememberedFile();
  if (!file || isSpecial(*file)) return;
  try {
    writeRemembered(*file, remembered);
  } catch (const InputError& error) {
    logDetail(std::string("what the window remembers was not kept: ") + error.what());
  }
}

/// For those who want to go on where they were.
void keepLastSession(const Session& session) {
  const std::optional<std::filesystem::path> file = lastSessionFile();
  if (!file || isSpecial(*file) || session.scene() == nullptr || !session.origin()) return;
  try {
    std::filesystem::create_directories(file->parent_path());
    writeFileWhole(*file, textOf(sessionFileOf(session)));
  } catch (const std::exception& error) {
    logDetail(std::string("the session was not kept: ") + error.what());
  }
}

HeldKeys heldKeys(const Window& window) {
  if (ImGui::GetIO().WantTextInput) return {};
  const auto isDown = [&](Action action) {
    const std::vector<KeyChord> keys = chordsOf(describe(action));
    return std::ranges::any_of(keys, [&](const KeyChord& key) { return window.isHeld(key); });
  };
  return {.reference = isDown(Action::showReference), .blink = isDown(Action::blink)};
}

/// What the main loop works with.
struct Stage {
  Window& window;
  Session& session;
  const SceneOpener& openScene;
  Clock& clock;
  const WindowSettings& settings;
  WindowReport& report;
  Remembered& remembered;
};

/// Runs until the window is to be closed; the photograph, if one was asked for.
Image<Rgba8> runLoop(const Stage& stage, const std::stop_token& stop) {
  const auto& [window, session, openScene, clock, settings, report, remembered] = stage;
  const std::stop_callback wakeUp(stop, [] { Window::wake(); });
  MainView mainView(window.gl(), openScene, settings.sweep, remembered, [] { Window::wake(); });
  mainView.watchTransferFile(settings.transferFile, [] { Window::wake(); });
  mainView.useDesktopDialogs([] { Window::wake(); });
  if (settings.sweep) session.setFront(settings.sweep->choice);
  RateMeter displayRate;
  Hover hover;
  const Clock::TimePoint start = clock.now();
  Clock::TimePoint lastActive = start;
  std::string shownScene;
  bool hasRecorded = false;
  bool startsDemo = settings.startsDemo;
  Image<Rgba8> photograph;
  const struct AtEnd {
    Window& window;
    ~AtEnd() { window.letOthersGoOn(); }  // the session ends next, and does not wait for long
  } atEnd{window};
  while (!stop.stop_requested()) {
    if (window.shouldClose()) {
      if (mainView.mayClose(session)) break;
      window.keepOpen();
      lastActive = clock.now();
    }
    const bool isMoving = clock.now() - lastActive < kLinger;
    window.waitForNextFrame(isMoving || !session.loading().empty());
    const Clock::TimePoint now = clock.now();
    if (session.update(now)) lastActive = now;
    const bool hasFailed = session.scene() == nullptr && session.loading().empty() && !session.error().empty();
    if (hasFailed && !settings.screenshot.empty()) throw InputError(session.error());  // there is nobody to read it in the window
    if (session.scene() != nullptr && session.scene()->name != shownScene) {
      shownScene = session.scene()->name;
      window.setTitle(shownScene + " – warpscope");
    }

    if (startsDemo && session.scene() != nullptr) {
      mainView.start(demos().front(), session);
      startsDemo = false;
    }
    if (!hasRecorded && !settings.recording.empty() && session.scene() != nullptr) {
      session.startRecording(settings.recording, textForRecording(session));
      mainView.noteRecording(settings.recording);
      hasRecorded = true;
    }
    const Clock::TimePoint updated = clock.now();
    window.beginFrame();
    if (window.hadInput()) lastActive = now;
    if (isMoving)
      displayRate.tick(now);
    else
      displayRate.clear();
    if (!settings.report.empty()) report.add(session, now, isMoving);
    mainView.draw(session, isMoving ? displayRate.perSecond(now) : 0.0, heldKeys(window),
                  {window.fonts(), window.scale(), window.pixelsPerUnit(), now, &hover, window.takeDoubleClick()});
    if (mainView.isAnimating()) lastActive = now;
    for (const KeyChord& key : window.takeKeyPresses()) mainView.press(key, session);
    bool wantsPicture = false;
    const bool goesOn = perform(window, mainView.takeWindowActions(), wantsPicture);
    mainView.open(window.takeDroppedFiles());
    const bool isLast = !settings.screenshot.empty() && now >= start + durationOfMs(settings.screenshotAfterMs);
    const Clock::TimePoint laidOut = clock.now();
    window.endFrame(isLast || wantsPicture ? &photograph : nullptr);
    if (const Clock::TimePoint shown = clock.now(); !settings.report.empty())
      report.add({millisecondsBetween(now, updated), millisecondsBetween(updated, laidOut), millisecondsBetween(laidOut, shown),
                  std::chrono::duration<double>(shown.time_since_epoch()).count()});
    if (wantsPicture) mainView.savePicture(isLast ? photograph : std::exchange(photograph, {}));
    if (isLast || !goesOn) break;
  }
  return photograph;
}

}  // namespace
}  // namespace ui

void runWindow(const SessionMaker& makeSession, const SceneOpener& openScene, Clock& clock, const WindowSettings& settings,
               const std::stop_token& stop) {
  const bool isForScripts = !settings.screenshot.empty();
  const std::optional<std::filesystem::path> file = rememberedFile();
  Remembered remembered = isForScripts || !file ? Remembered{} : readRemembered(*file);
  const bool wasLight = remembered.isLight;
  if (settings.isLight) remembered.isLight = *settings.isLight;
  ui::Window window("warpscope", settings.uiScale, settings.size, remembered.windowSize);
  std::unique_ptr<Session> session = makeSession([] { ui::Window::wake(); });
  WindowReport report;
  const Image<Rgba8> photograph = ui::runLoop({window, *session, openScene, clock, settings, report, remembered}, stop);
  const std::string figures = settings.report.empty() ? "" : report.text(*session, clock.now());
  if (!isForScripts) {
    ui::keepLastSession(*session);
    if (!settings.size) remembered.windowSize = glm::uvec2(glm::vec2(window.size()) / window.scale());  // another time at another scale
    if (remembered.isLight == settings.isLight) remembered.isLight = wasLight;  // that was asked for this once
    ui::keep(remembered);
  }
  const bool hasEnded = session->close(ui::kClosingPatience);
  const std::string recordingError = session->recordingFailure();
  if (!hasEnded) {  // a reader that cannot be interrupted must not keep a closed window's process
    static_cast<void>(session.release());
    noteLeftAlone();
  }
  if (!photograph.empty()) writeFileWhole(settings.screenshot, encodePng(photograph));
  if (!settings.report.empty()) writeFileWhole(settings.report, figures);
  if (recordingError.empty()) return;
  const std::string sentence = "the recording is not whole: " + recordingError;
  if (!settings.recording.empty()) throw InputError(sentence);
  logWarning(sentence);
}

}  // namespace warpscope
