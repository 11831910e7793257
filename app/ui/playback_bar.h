// The bar of a recording that is on show: where in it one is, and what moves it on.
#pragma once

#include "app/ui/parts.h"

namespace warpscope::ui {

/// ImGui units, where it is that wide; 0 where no recording is on show.
float playbackHeight(const Session& session, float width, const Look& look);

/// Fills the line, or two where one has no room for all. True when the recording is to be exported, or that given up.
bool drawPlayback(Session& session, float width, const Look& look);

}  // namespace warpscope::ui
