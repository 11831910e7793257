// Grounds: of child windows, of plots. They are most of what is filled, and where the CPU draws the window, filling is most of its work: they are cleared, which is
// several times as fast as a blended rectangle of a texture, as all that ImGui draws is.
#pragma once

#include <imgui.h>

#include "app/ui/texture.h"

namespace warpscope::ui {

/// A rectangle, to the nearest pixel, of that colour of the style, ImGuiCol_ChildBg or ImGuiCol_WindowBg, which are opaque.
void fillGround(ImDrawList& list, const WindowGl& gl, const ImVec2& begin, const ImVec2& end, ImGuiCol color, float rounding);

/// ImGui::BeginChild() of a child window with a border, whose ground ImGui need not draw.
bool beginChildOnGround(const WindowGl& gl, const char* id, const ImVec2& size, ImGuiWindowFlags flags = 0);

}  // namespace warpscope::ui
