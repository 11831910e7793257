// What ImGui has to know of the window before each frame: its size, the time, pointer and buttons.
// In place of NewFrame of ImGui's backend for GLFW, of what GLFW's events have said: that asks the display's server five times a frame, and where all cores are busy each answer waits for
// the server's turn, together 10 ms and more. Keys, characters, the wheel and the clipboard remain the backend's.
#pragma once

#include <imgui.h>

#include <array>
#include <glm/vec2.hpp>

#include "render/base/clock.h"

struct GLFWcursor;
struct GLFWwindow;

namespace warpscope::ui {

class ImGuiFeed {
 public:
  explicit ImGuiFeed(GLFWwindow* window);
  ~ImGuiFeed();
  ImGuiFeed(const ImGuiFeed&) = delete;
  ImGuiFeed& operator=(const ImGuiFeed&) = delete;

  // By events.
  void setSize(const glm::ivec2& size) { size_ = size; }                ///< in screen coordinates
  void setFramebufferSize(const glm::ivec2& size) { framebuffer_ = size; }  ///< in pixels
  void movePointer(const glm::dvec2& at) { pointer_ = at; }             ///< in screen coordinates, also beside the window while a button is held
  void enter(bool isInside) { isInside_ = isInside; }
  void press(int button, bool isDown);
  /// The sizes as they are by now, whose events are on their way.
  void askForSizes();

  const glm::ivec2& size() const { return size_; }
  const glm::ivec2& framebufferSize() const { return framebuffer_; }
  const glm::dvec2& pointer() const { return pointer_; }

  void beginFrame();

 private:
  void showCursor();

  static constexpr size_t kButtons = sizeof(ImGuiIO::MouseDown) / sizeof(bool);
  GLFWwindow* window_ = nullptr;
  glm::ivec2 size_{0}, framebuffer_{0};
  glm::dvec2 pointer_{0.0};
  bool isInside_ = false;
  std::array<bool, kButtons> isDown_{}, wasPressed_{};  // at the moment; since the last frame, although it may be up again
  Clock::TimePoint last_{};
  std::array<GLFWcursor*, ImGuiMouseCursor_COUNT> cursors_{};
  ImGuiMouseCursor cursor_ = ImGuiMouseCursor_Arrow;
};

}  // namespace warpscope::ui
