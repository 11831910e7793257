// A window with an OpenGL context and ImGui in it: opening, scaling, pacing, closing.
// GLFW 3.3 and Dear ImGui 1.86 with their own backends; one window at a time, on the main thread.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "app/session/actions.h"
#include "app/ui/double_click.h"
#include "app/ui/imgui_feed.h"
#include "app/ui/texture.h"
#include "app/ui/theme.h"
#include "render/base/clock.h"
#include "render/core/crew.h"

struct GLFWwindow;

namespace warpscope::ui {

class Window {
 public:
  /// `uiScale` 0 follows the screen's content scale; `size` is in screen coordinates, and without one the usual size is taken. Throws NoDisplay
  /// if there is no screen or no OpenGL on it, UsageError for a size that is less than the window's parts need or more than the screens have.
  /// `usual`: that is taken where `size` is not given, as far as the screen has room for it.
  Window(const std::string& title, double uiScale, const std::optional<glm::uvec2>& size, const std::optional<glm::uvec2>& usual = {});
  ~Window();
  Window(const Window&) = delete;
  Window& operator=(const Window&) = delete;

  bool shouldClose() const;
  /// Whoever wanted to close it thinks better of it.
  void keepOpen();
  void setTitle(const std::string& title);

  /// Lets events come in until the next picture is due: at the screen's rate while something moves, seldom while nothing does.
  void waitForNextFrame(bool isMoving);
  /// What stands back need not wait for the next frame: there will be none.
  void letOthersGoOn() { othersPause_.reset(); }
  /// Ends a wait; from any thread.
  static void wake();

  void beginFrame();
  /// Draws what ImGui was told since beginFrame(); leaves the window's picture in `photograph` if that is not null.
  void endFrame(Image<Rgba8>* photograph = nullptr);

  const WindowGl& gl() const { return *gl_; }
  const Fonts& fonts() const { return fonts_; }
  /// ImGui units that a length of 1 at scale 1 takes.
  float scale() const { return scale_; }
  /// Framebuffer pixels of one ImGui unit.
  float pixelsPerUnit() const { return pixelsPerUnit_; }
  /// Keys pressed since the last call. Letters are what the keyboard's layout says; digits are by position.
  std::vector<KeyChord> takeKeyPresses() { return std::exchange(keyPresses_, {}); }
  /// Whether a key that actions name is down at the moment.
  bool isHeld(const KeyChord& key) const;
  /// On the whole screen that most of it is on, or as it was before.
  void setFullScreen(bool isFullScreen);
  bool isFullScreen() const;
  /// In screen coordinates; of the window that is not on the whole screen.
  glm::uvec2 size() const;
  /// The files that were dropped onto the window together, the last time since the last call.
  std::vector<std::string> takeDroppedFiles() { return std::exchange(droppedFiles_, {}); }
  /// Whether the left button was pressed twice, quickly and at one place, since the last call.
  bool takeDoubleClick() { return std::exchange(isDoubleClicked_, false); }
  /// True if the user did anything to the window since the last frame.
  bool hadInput() const { return hadInput_; }

 private:
  friend struct WindowEvents;
  void open(const std::string& title);
  void listen();
  void startImGui();
  /// A frame that nobody sees: what drivers and ImGui do once takes as long as several frames.
  void warmUp();
  void showAt(const std::optional<glm::uvec2>& size, const std::optional<glm::uvec2>& usual);
  void close();
  void followScale(bool isFirst);
  void holdShortKeys();
  void takeEvents(double patienceS);
  /// Whether the CPU draws the window, and takes long for it.
  bool isDear() const;
  Moment momentOfEvent() const;

  const double uiScale_;
  GLFWwindow* window_ = nullptr;
  std::unique_ptr<WindowGl> gl_;
  std::unique_ptr<ImGuiFeed> feed_;
  Fonts fonts_;
  float scale_ = 1.0f;
  float pixelsPerUnit_ = 1.0f;
  Clock::TimePoint frameBegan_{};
  double frameMs_ = 0.0;  // that frames take this thread, smoothed
  std::array<double, 16> lastFramesMs_{};  // that the last ones took it
  std::optional<Crew::Break> othersPause_;  // while a frame is drawn that is dear, until the next is waited for
  bool hadInput_ = false, hasInput_ = false;
  Clock::TimePoint askedForEvents_{}, tookEvents_{};  // when GLFW was last asked, and when it last returned
  DoubleClick clicks_;
  bool isDoubleClicked_ = false;
  std::vector<KeyChord> keyPresses_;
  struct Place {
    glm::ivec2 at{0}, size{0};
  };
  Place beforeFullScreen_;
  struct KeyPress {
    int key = 0, modifiers = 0;  // GLFW's codes
  };
  std::vector<KeyPress> pressedKeys_;   // since the last frame
  std::vector<int> heldKeys_;           // for a frame, although they are up again
  std::vector<unsigned int> laterCharacters_;
  std::vector<std::string> droppedFiles_;
};

}  // namespace warpscope::ui
