// Filling ImGuiIO.
// See imgui_feed.h.
#include "app/ui/imgui_feed.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include <algorithm>
#include <cfloat>
#include <utility>

namespace warpscope::ui {

ImGuiFeed::ImGuiFeed(GLFWwindow* window) : window_(window) {
  askForSizes();
  constexpr std::array<std::pair<ImGuiMouseCursor, int>, 5> kShapes{{{ImGuiMouseCursor_Arrow, GLFW_ARROW_CURSOR},
                                                                      {ImGuiMouseCursor_TextInput, GLFW_IBEAM_CURSOR},
                                                                      {ImGuiMouseCursor_ResizeNS, GLFW_VRESIZE_CURSOR},
                                                                      {ImGuiMouseCursor_ResizeEW, GLFW_HRESIZE_CURSOR},
                                                                      {ImGuiMouseCursor_Hand, GLFW_HAND_CURSOR}}};
  for (const auto& [cursor, shape] : kShapes) cursors_[static_cast<size_t>(cursor)] = glfwCreateStandardCursor(shape);
}

ImGuiFeed::~ImGuiFeed() {
  for (GLFWcursor* cursor : cursors_) glfwDestroyCursor(cursor);
}

void ImGuiFeed::press(int button, bool isDown) {
  if (button < 0 || button >= static_cast<int>(kButtons)) return;
  isDown_[static_cast<size_t>(button)] = isDown;
  if (isDown) wasPressed_[static_cast<size_t>(button)] = true;
}

void ImGuiFeed::askForSizes() {
  glfwGetWindowSize(window_, &size_.x, &size_.y);
  glfwGetFramebufferSize(window_, &framebuffer_.x, &framebuffer_.y);
}

void ImGuiFeed::beginFrame() {
  ImGuiIO& io = ImGui::GetIO();
  io.DisplaySize = {static_cast<float>(size_.x), static_cast<float>(size_.y)};
  if (size_.x > 0 && size_.y > 0)
    io.DisplayFramebufferScale = {static_cast<float>(framebuffer_.x) / io.DisplaySize.x, static_cast<float>(framebuffer_.y) / io.DisplaySize.y};
  const Clock::TimePoint now = Clock::TimePoint::clock::now();
  constexpr float kUsualS = 1.0f / 60.0f, kLeastS = 1e-5f;
  io.DeltaTime = last_ == Clock::TimePoint{} ? kUsualS : std::max(kLeastS, std::chrono::duration<float>(now - last_).count());
  last_ = now;
  for (size_t i = 0; i < kButtons; ++i) io.MouseDown[i] = std::exchange(wasPressed_[i], false) || isDown_[i];
  const bool isKnown = isInside_ || std::ranges::any_of(io.MouseDown, [](bool isDown) { return isDown; });
  io.MousePos = isKnown ? ImVec2(static_cast<float>(pointer_.x), static_cast<float>(pointer_.y)) : ImVec2(-FLT_MAX, -FLT_MAX);
  showCursor();
}

void ImGuiFeed::showCursor() {
  const ImGuiMouseCursor wanted = ImGui::GetMouseCursor();  // the last frame's
  if (wanted == cursor_ || wanted < 0) return;
  cursor_ = wanted;
  GLFWcursor* const shape = cursors_[static_cast<size_t>(wanted)];
  glfwSetCursor(window_, shape != nullptr ? shape : cursors_[ImGuiMouseCursor_Arrow]);
}

}  // namespace warpscope::ui
