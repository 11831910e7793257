// Pages over the window that say something and go: all keys, and what program this is on what machine.
#pragma once

#include <string>

#include "app/session/session.h"
#include "app/ui/parts.h"

namespace warpscope::ui {

void drawKeysPage(bool& isOpen, const Look& look);

/// `renderer`: of the window, as OpenGL's driver calls itself.
void drawAboutPage(bool& isOpen, const Session& session, const std::string& renderer, const Look& look);

}  // namespace warpscope::ui
