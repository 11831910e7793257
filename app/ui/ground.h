// Grounds of child windows. They are most of what is filled, and where the CPU draws the window, filling is most of its work: they are cleared, which is
// several times as fast as a blended rectangle of a texture, as all that ImGui draws is.
#pragma once

#include <imgui.h>

#include "app/ui/texture.h"

namespace warpscope::ui {

/// ImGui::BeginChild() of a child window with a border, whose ground ImGui need not draw.
bool beginChildOnGround(const WindowGl& gl, const char* id, const ImVec2& size, ImGuiWindowFlags flags = 0);

}  // namespace warpscope::ui
