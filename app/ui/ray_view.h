// What there is along the ray that is looked at: values, opacity, what light is left, segments, and where each heuristic puts its depth.
#pragma once

#include "app/ui/parts.h"

namespace warpscope::ui {

/// Fills the current child window. False if the user closed it.
bool drawRay(const Session& session, const Look& look);

}  // namespace warpscope::ui
