// What stands above a panel's picture: its title, which drags it, and the technique, the content and the knobs that are chosen for it.
#pragma once

#include <optional>

#include "app/session/actions.h"
#include "app/ui/parts.h"

namespace warpscope::ui {

/// Of what a title drags: the id of its panel.
inline constexpr const char* kPanelPayload = "panel";

/// Height of drawPanelHeader(), with the space beneath it.
float panelHeaderHeight(const Look& look);

/// Two lines over the width of the current window. What the user asked of the panel, by one of its buttons.
std::optional<Action> drawPanelHeader(Session& session, size_t index, bool isAlone, const Look& look);

}  // namespace warpscope::ui
