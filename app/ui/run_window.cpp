// The window's main loop: events, session, panels, picture.
// See run_window.h.
#include "app/ui/run_window.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "app/picture/picture.h"
#include "app/session/window_report.h"
#include "app/shell/output_files.h"
#include "app/ui/parts.h"
#include "app/ui/plot_view.h"
#include "app/ui/window.h"

namespace warpscope {
namespace ui {
namespace {

constexpr float kControlsWidth = 268.0f, kStatusHeight = 28.0f, kMargin = 8.0f;  // at scale 1
/// For threads to end, and for leaving a server far away.
constexpr std::chrono::milliseconds kClosingPatience(900);
/// After the last event the display keeps its rate for this long.
constexpr std::chrono::milliseconds kLinger(500);

class MainView {
 public:
  MainView(const Window& window, const SceneOpener& openScene, std::optional<SweepFile> sweep)
      : textures_{PictureTexture(window.gl()), PictureTexture(window.gl())}, plot_(std::move(sweep)), openScene_(openScene) {}

  /// A file that the user handed over: a sweep for the plot, or else a scene.
  void open(const std::string& path, Session& session) {
    if (std::filesystem::path(path).extension() == ".json")
      fileSorter_->post(path);
    else
      session.load(openScene_(path));
  }

  void draw(Session& session, double displayFramesPerSecond, const Look& look) {
    const ImGuiIO& io = ImGui::GetIO();
    ImGui::SetNextWindowPos({0.0f, 0.0f});
    ImGui::SetNextWindowSize(io.DisplaySize);
    ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {look.px(kMargin), look.px(kMargin)});
    ImGui::PushStyleVar(ImGuiStyleVar_ItemSpacing, {look.px(kMargin), look.px(kMargin)});
    ImGui::Begin("warpscope", nullptr,
                 ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoSavedSettings |
                     ImGuiWindowFlags_NoBringToFrontOnFocus | ImGuiWindowFlags_NoNav | ImGuiWindowFlags_NoScrollWithMouse);
    const float bodyHeight = std::max(1.0f, ImGui::GetContentRegionAvail().y - look.px(kStatusHeight));
    ImGui::PushStyleColor(ImGuiCol_ChildBg, kFrameColor);
    ImGui::BeginChild("panels", {ImGui::GetContentRegionAvail().x - look.px(kControlsWidth + kMargin), bodyHeight}, false,
                      ImGuiWindowFlags_NoScrollbar | ImGuiWindowFlags_NoScrollWithMouse);
    ImGui::PopStyleColor();
    takeHandedFile(session);
    drawErrorBanner(session, look);
    drawPanels(session, look);
    drawPlot(session, look);
    ImGui::EndChild();
    ImGui::PopStyleVar(2);

    ImGui::SameLine(0.0f, look.px(kMargin));
    ImGui::BeginChild("controls", {0.0f, bodyHeight}, true);
    controls_.draw(session, openScene_, look);
    ImGui::EndChild();
    ImGui::SetCursorPosY(ImGui::GetWindowHeight() - look.px(kStatusHeight));
    drawStatusBar(session, displayFramesPerSecond, look);
    ImGui::End();
  }

  /// The panel under the pointer in the last draw().
  std::optional<size_t> panelUnderPointer() const { return underPointer_; }

 private:
  void takeHandedFile(Session& session) {
    std::optional<HandedFile> file = fileSorter_->tryTake();
    if (!file) return;
    if (!file->error.empty()) {
      plot_.showError(std::move(file->error));
    } else if (file->sweep) {
      session.setFront(file->sweep->choice);
      plot_.showSweep(std::move(*file->sweep));
    } else {
      session.load(openScene_(file->path));
    }
  }

  void drawPlot(Session& session, const Look& look) {
    const ImGuiIO& io = ImGui::GetIO();
    const bool isUsed = io.MouseWheel != 0.0f || ImGui::IsMouseClicked(ImGuiMouseButton_Left) || ImGui::IsMouseClicked(ImGuiMouseButton_Right);
    if (underPointer_ && isUsed) usedLast_ = *underPointer_;
    for (size_t i = 0; i < kPanelCount; ++i) {
      const WarpDescriptor* technique = session.panel(i).technique;
      if (std::exchange(techniques_[i], technique) != technique) usedLast_ = i;  // by its list, or by a key
    }
    ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {look.px(8.0f), look.px(8.0f)});
    ImGui::PushStyleVar(ImGuiStyleVar_ItemSpacing, {look.px(8.0f), look.px(6.0f)});
    ImGui::BeginChild("plot", {0.0f, 0.0f}, true, ImGuiWindowFlags_NoScrollbar | ImGuiWindowFlags_NoScrollWithMouse);
    plot_.draw(session, usedLast_, look);
    ImGui::EndChild();
    ImGui::PopStyleVar(2);
  }

  void drawPanels(Session& session, const Look& look) {
    ImVec2 room = ImGui::GetContentRegionAvail();
    room.y = std::max(1.0f, room.y - plot_.height(room.y, look) - look.px(kMargin));
    const float width = std::floor(0.5f * (room.x - look.px(kMargin)));  // equal, so that pictures are
    underPointer_.reset();
    for (size_t i = 0; i < kPanelCount; ++i) {
      if (i > 0) ImGui::SameLine(0.0f, look.px(kMargin));
      ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {look.px(8.0f), look.px(8.0f)});
      ImGui::PushStyleVar(ImGuiStyleVar_ItemSpacing, {look.px(8.0f), look.px(6.0f)});
      ImGui::BeginChild(i == 0 ? "left" : "right", {width, room.y}, true,
                        ImGuiWindowFlags_NoScrollbar | ImGuiWindowFlags_NoScrollWithMouse);
      if (drawWarpPanel(session, i, textures_[i], look)) underPointer_ = i;
      ImGui::EndChild();
      ImGui::PopStyleVar(2);
    }
  }

  Controls controls_;
  std::array<PictureTexture, kPanelCount> textures_;
  PlotView plot_;
  size_t usedLast_ = 0;  // the panel whose technique changed last, or that was clicked into or turned the wheel over since
  std::array<const WarpDescriptor*, kPanelCount> techniques_{};
  const SceneOpener& openScene_;
  std::optional<size_t> underPointer_;
  std::unique_ptr<FileSorter> fileSorter_ = makeFileSorter([] { Window::wake(); });
};

/// From the picture to what was shown in its place last, and back.
void toggleContent(Session& session, size_t index) {
  const Panel& panel = session.panel(index);
  session.setContent(index, panel.content == PictureContent::picture ? panel.lastContent : PictureContent::picture, panel.contentRange);
}

/// Keys that act on the session. Returns false for those that close the window.
bool handleKeys(Window& window, Session& session, std::optional<size_t> panel) {
  for (const KeyPress& key : window.takeKeyPresses()) {
    if (key.isControl && key.character == 'q') return false;
    if (ImGui::GetIO().WantTextInput) continue;
    if (key.isEscape && !ImGui::IsPopupOpen(nullptr, ImGuiPopupFlags_AnyPopup)) return false;
    if (key.isControl) continue;
    if (key.character == 'r') session.resetView();
    if (key.character == 'f') {
      LiveSettings knobs = session.knobs();
      knobs.isFrozen = !knobs.isFrozen;
      session.setKnobs(knobs);
    }
    if (key.character == 'e') session.setShowsPlan(!session.showsPlan());
    if (key.character == '0' && panel) session.setAutomatic(*panel);
    if (key.character == 'h' && panel) toggleContent(session, *panel);
    const size_t number = static_cast<size_t>(key.character - '1');
    if (key.character >= '1' && key.character <= '9' && panel && number < warpRegistry().size())
      session.setTechnique(*panel, warpRegistry()[number]);
  }
  return true;
}

/// What the main loop works with.
struct Stage {
  Window& window;
  Session& session;
  const SceneOpener& openScene;
  Clock& clock;
  const WindowSettings& settings;
  WindowReport& report;
};

/// Runs until the window is to be closed; the photograph, if one was asked for.
Image<Rgba8> runLoop(const Stage& stage, const std::stop_token& stop) {
  const auto& [window, session, openScene, clock, settings, report] = stage;
  const std::stop_callback wakeUp(stop, [] { Window::wake(); });
  MainView mainView(window, openScene, settings.sweep);
  if (settings.sweep) session.setFront(settings.sweep->choice);
  RateMeter displayRate;
  Hover hover;
  const Clock::TimePoint start = clock.now();
  Clock::TimePoint lastActive = start;
  std::string shownScene;
  Image<Rgba8> photograph;
  while (!window.shouldClose() && !stop.stop_requested()) {
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

    window.beginFrame();
    if (window.hadInput()) lastActive = now;
    if (isMoving)
      displayRate.tick(now);
    else
      displayRate.clear();
    if (!settings.report.empty()) report.add(session, now, isMoving);
    mainView.draw(session, isMoving ? displayRate.perSecond(now) : 0.0,
                  {window.fonts(), window.scale(), window.pixelsPerUnit(), now, &hover, window.takeDoubleClick()});
    const bool goesOn = handleKeys(window, session, mainView.panelUnderPointer());
    if (const std::optional<std::string> file = window.takeDroppedFile()) mainView.open(*file, session);
    const bool isLast = !settings.screenshot.empty() && now >= start + durationOfMs(settings.screenshotAfterMs);
    window.endFrame(isLast ? &photograph : nullptr);
    if (isLast || !goesOn) break;
  }
  return photograph;
}

}  // namespace
}  // namespace ui

bool runWindow(const SessionMaker& makeSession, const SceneOpener& openScene, Clock& clock, const WindowSettings& settings,
               const std::stop_token& stop) {
  ui::Window window("warpscope", settings.uiScale, settings.size);
  std::unique_ptr<Session> session = makeSession([] { ui::Window::wake(); });
  WindowReport report;
  const Image<Rgba8> photograph = ui::runLoop({window, *session, openScene, clock, settings, report}, stop);
  if (!settings.report.empty()) writeFileWhole(settings.report, report.text(*session, clock.now()));
  const bool hasEnded = session->close(ui::kClosingPatience);
  if (!photograph.empty()) writeFileWhole(settings.screenshot, encodePng(photograph));
  if (!hasEnded) static_cast<void>(session.release());  // its thread still uses it
  return hasEnded;
}

}  // namespace warpscope
