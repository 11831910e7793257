// All that the window shows, drawn by Dear ImGui without a window and handled by scripts: pointer, wheel, keys, typed text. What is drawn goes nowhere, unless a
// DrawnWindow takes it.
// One display frame for each step of a script, as many as it waits for.
#pragma once

#include <imgui.h>

#include <string>

#include "app/ui/main_view.h"
#include "app/ui/theme.h"
#include "tests/drawn_window.h"
#include "tests/session_fixture.h"
#include "tests/test_folder.h"

namespace warpscope::ui {

/// OpenGL that does nothing.
WindowGl noGl();

class ScriptedWindow {
 public:
  ScriptedWindow(const glm::uvec2& size, Session& session, const SceneOpener& openScene, std::unique_ptr<DrawnWindow> drawn = nullptr);
  ~ScriptedWindow();
  ScriptedWindow(const ScriptedWindow&) = delete;
  ScriptedWindow& operator=(const ScriptedWindow&) = delete;

  /// One frame of the display.
  void frame();
  void frames(int count);
  /// As many as it takes until that is so; false if that takes longer than kPatience.
  template <class Predicate>
  bool framesUntil(const Predicate& predicate) {
    for (const auto deadline = clock_.now() + kPatience; clock_.now() < deadline; std::this_thread::sleep_for(milliseconds(1))) {
      frame();
      if (predicate()) return true;
    }
    return false;
  }
  void resize(const glm::uvec2& size) { ImGui::GetIO().DisplaySize = {static_cast<float>(size.x), static_cast<float>(size.y)}; }

  void moveTo(const glm::vec2& at);
  void hold(int button, bool isDown);
  void click(const glm::vec2& at, int button = 0);
  void doubleClick(const glm::vec2& at);
  void drag(const glm::vec2& from, const glm::vec2& to, int button = 0);
  void wheel(float notches);
  void key(const KeyChord& chord);
  void type(const std::string& text);
  Remembered remembered;
  /// Keys that stay down.
  HeldKeys held;

  MainView& view() { return view_; }
  /// Of the last frame; there is a DrawnWindow.
  Image<Rgba8> picture() {
    const ImVec2 size = ImGui::GetIO().DisplaySize;
    return drawn_->picture({static_cast<uint32_t>(size.x), static_cast<uint32_t>(size.y)});
  }
  /// Where it is while it is there: what it keeps lies there.
  const TestFolder& folder() const { return place_.folder; }
  /// What the window was asked to do that a script has not taken yet.
  std::vector<Action> takeActions() { return view_.takeWindowActions(); }
  std::string clipboard() const { return clipboard_; }

 private:
  struct Place {
    Place() { std::filesystem::current_path(folder.path()); }
    ~Place() { std::filesystem::current_path(before); }
    const std::filesystem::path before = std::filesystem::current_path();
    const TestFolder folder;
  };
  const Place place_;
  Session& session_;
  ImGuiContext* const context_;
  const std::unique_ptr<DrawnWindow> drawn_;
  const WindowGl gl_;
  Fonts fonts_;
  Hover hover_;
  SteadyClock clock_;
  MainView view_;
  bool isDoubleClick_ = false;
  std::string clipboard_;
};

}  // namespace warpscope::ui
