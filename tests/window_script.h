// The window in the hands of a script: what its tests share.
#pragma once

#include "app/session/recorded_scene.h"
#include "tests/scripted_window.h"
#include "tests/test_folder.h"

namespace warpscope::ui {

inline constexpr glm::uvec2 kSize(1280, 800);
inline constexpr glm::vec2 kLeftPicture(250.0f, 250.0f), kRightPicture(750.0f, 250.0f), kLeftTitle(120.0f, 47.0f), kRightTitle(600.0f, 47.0f);
inline constexpr glm::vec2 kChart(1130.0f, 205.0f);

class WindowScriptTest : public SessionTest {
 protected:
  WindowScriptTest() : window_(kSize, session_, opener_) {}

  template <class Predicate>
  bool waitUntil(const Predicate& predicate) {
    return window_.framesUntil(predicate);
  }
  LoadJob jobOf(const SceneOrigin& origin) {
    LoadJob job = builtin(origin.spec);
    if (isRecording(origin.spec))
      job = {origin.spec, [spec = origin.spec](const std::function<void()>& onNews, const std::stop_token& stop) { return openRecording(spec, Backend::cpu, onNews, stop); }};
    job.origin = origin;
    return job;
  }
  bool openAndRest(const std::string& name) {
    session_.load(jobOf({name, {}}));
    return rest();
  }
  /// Until all that is on show is of now and judged.
  bool rest() {
    return waitUntil([&] {
      if (session_.scene() == nullptr || !session_.loading().empty()) return false;
      for (size_t i = 0; i < session_.panelCount(); ++i) {
        const Panel& panel = session_.panel(i);
        if (!panel.isHidden && (panel.currentPixels() == nullptr || !panel.errorsAreCurrent || panel.drawn != panel.technique)) return false;
      }
      return true;
    });
  }

  /// A key of Dear ImGui's own.
  void tap(ImGuiKey key) {
    ImGui::GetIO().KeysDown[key] = true;
    window_.frame();
    ImGui::GetIO().KeysDown[key] = false;
    window_.frame();
  }
  static bool hasPopup() { return ImGui::IsPopupOpen(nullptr, ImGuiPopupFlags_AnyPopup); }

  void press(Action action) {
    const std::vector<KeyChord> chords = chordsOf(describe(action));
    if (chords.empty())
      window_.view().perform(action, session_);
    else
      window_.key(chords.front());
  }

  SceneOpener opener_ = [this](const SceneOrigin& origin) { return jobOf(origin); };
  ScriptedWindow window_;
};

}  // namespace warpscope::ui
