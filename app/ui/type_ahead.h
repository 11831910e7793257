// What is typed between asking for a field and the frame of the display in which that field takes text.
// A key that asks for a field and the letters after it may come within one frame; without this they would be shortcuts, and lost to the field.
#pragma once

#include <imgui.h>

#include <vector>

namespace warpscope::ui {

class TypeAhead {
 public:
  /// A field was asked for: what has been typed since the frame began, and what will be, is its.
  void begin() {
    framesLeft_ = kPatience;
    typed_.clear();
    takeQueue();
  }
  /// At the beginning of each frame: hands on what was typed, as soon as a field takes it. If none does, it is forgotten.
  void beginFrame() {
    if (!isWaiting()) return;
    ImGuiIO& io = ImGui::GetIO();
    --framesLeft_;
    takeQueue();
    io.ClearInputCharacters();
    // The first frames may still be those of another field, which is about to lose the keyboard.
    if (!io.WantTextInput || framesLeft_ > kPatience - kFramesToFocus) return;
    for (const ImWchar character : typed_) io.AddInputCharacter(character);
    framesLeft_ = 0;
  }
  bool isWaiting() const { return framesLeft_ > 0; }

 private:
  void takeQueue() {
    const ImVector<ImWchar>& queue = ImGui::GetIO().InputQueueCharacters;
    typed_.insert(typed_.end(), queue.begin(), queue.end());
  }

  static constexpr int kPatience = 10, kFramesToFocus = 3;
  int framesLeft_ = 0;
  std::vector<ImWchar> typed_;
};

}  // namespace warpscope::ui
