// Stands in for the window in builds without one.
// See run_window.h; the build's option is WARPSCOPE_WITH_UI.
#include "app/ui/run_window.h"

namespace warpscope {

void runWindow(const SessionMaker&, const SceneOpener&, Clock&, const WindowSettings&, const std::stop_token&) {
  throw NoDisplay("this build has no window (WARPSCOPE_WITH_UI=OFF)");
}

}  // namespace warpscope
