// The window, as the rest of the program sees it.
// What implements it is the only code that knows ImGui and GLFW; builds without a window have run_window_none.cpp instead.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <stop_token>

#include "app/experiment/sweep_file.h"
#include "app/session/session_file.h"
#include "render/base/error.h"

namespace warpscope {

/// There is no screen to open a window on, or this build has no window.
class NoDisplay : public InputError {
 public:
  using InputError::InputError;
};

struct WindowSettings {
  std::optional<glm::uvec2> size;    ///< in screen coordinates; default: 1280x800 times the scale, as far as the screen has room for it
  std::optional<bool> isLight;       ///< the theme, this once; default: as it was last
  double uiScale = 0.0;              ///< size of everything, 1: that of a usual screen; 0: as the screen says
  std::filesystem::path screenshot;  ///< if not empty: a PNG of the window is written here, then the window closes
  double screenshotAfterMs = 3000.0;
  std::optional<SweepFile> sweep;    ///< that the plot shows as well
  bool startsDemo = false;             ///< the first demonstration begins with the first scene
  std::filesystem::path recording;     ///< if not empty: frames and camera are recorded into it from the first scene on (frames/recording.h)
  std::filesystem::path transferFile;  ///< if not empty: a transfer function that is loaded again whenever it is written
  std::filesystem::path report;      ///< if not empty: a WindowReport is written here when the window closes
};

/// Makes the session once the window is open; gets what the session calls when it has news.
using SessionMaker = std::function<std::unique_ptr<Session>(std::function<void()> onNews)>;
/// Opens a scene that the user has chosen.
using SceneOpener = OriginOpener;

/// Opens the window and returns when it is closed or `stop` is set. Throws NoDisplay before anything was done, UsageError for a size that is less
/// than the window's parts need or more than the screens have, InputError if the
/// screenshot, the report or a recording cannot be written or nothing can be shown on it. If the session does not end in time (see Session::close) it lives on, and is noted as left alone (abandonable.h).
void runWindow(const SessionMaker& makeSession, const SceneOpener& openScene, Clock& clock, const WindowSettings& settings,
               const std::stop_token& stop);

}  // namespace warpscope
