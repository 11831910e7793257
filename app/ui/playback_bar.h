// The bar of a recording that is on show: where in it one is, and what moves it on.
#pragma once

#include "app/ui/parts.h"

namespace warpscope::ui {

/// ImGui units; 0 where no recording is on show.
float playbackHeight(const Session& session, const Look& look);

/// Fills the line.
void drawPlayback(Session& session, const Look& look);

}  // namespace warpscope::ui
