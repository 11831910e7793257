// The middle by a clear of the scissor's rectangle, the rim with its round corners by ImGui.
// See ground.h.
#include "app/ui/ground.h"

#include <algorithm>
#include <cmath>

namespace warpscope::ui {
namespace {

/// What ImGui's backend calls amidst its commands; each sets the scissor itself. The command's clip rectangle is what is cleared.
void clear(const ImDrawList* /*list*/, const ImDrawCmd* command) {
  const WindowGl& gl = *static_cast<const WindowGl*>(command->UserCallbackData);
  const ImDrawData& display = *ImGui::GetDrawData();
  const ImVec2 scale = display.FramebufferScale, origin = display.DisplayPos;
  const ImVec4& clip = command->ClipRect;
  const int left = static_cast<int>(std::lround((clip.x - origin.x) * scale.x)), right = static_cast<int>(std::lround((clip.z - origin.x) * scale.x));
  const int top = static_cast<int>(std::lround((clip.y - origin.y) * scale.y)), bottom = static_cast<int>(std::lround((clip.w - origin.y) * scale.y));
  const int height = static_cast<int>(std::lround(display.DisplaySize.y * scale.y));
  if (left >= right || top >= bottom) return;
  const ImVec4& color = ImGui::GetStyle().Colors[ImGuiCol_ChildBg];
  gl.scissor(left, height - bottom, right - left, bottom - top);
  gl.clearColor(color.x, color.y, color.z, 1.0f);
  gl.clear(GL_COLOR_BUFFER_BIT);
}

void fill(ImDrawList& list, const WindowGl& gl, const ImVec2& from, const ImVec2& to) {
  const ImU32 color = ImGui::GetColorU32(ImGuiCol_ChildBg);
  const float rounding = ImGui::GetStyle().ChildRounding, rim = std::ceil(rounding) + 1.0f;
  const ImVec2 innerFrom{std::ceil(from.x + rim), std::ceil(from.y + rim)}, innerTo{std::floor(to.x - rim), std::floor(to.y - rim)};
  if (innerFrom.x >= innerTo.x || innerFrom.y >= innerTo.y) return list.AddRectFilled(from, to, color, rounding);
  list.PushClipRect(innerFrom, innerTo, true);
  list.AddCallback(clear, const_cast<WindowGl*>(&gl));
  list.PopClipRect();
  // Over a pixel of what is cleared, whose colour is the same: their edges are smoothed.
  list.AddRectFilled(from, {to.x, innerFrom.y + 1.0f}, color, rounding, ImDrawFlags_RoundCornersTop);
  list.AddRectFilled({from.x, innerTo.y - 1.0f}, to, color, rounding, ImDrawFlags_RoundCornersBottom);
  list.AddRectFilled({from.x, innerFrom.y}, {innerFrom.x + 1.0f, innerTo.y}, color);
  list.AddRectFilled({innerTo.x - 1.0f, innerFrom.y}, {to.x, innerTo.y}, color);
}

}  // namespace

bool beginChildOnGround(const WindowGl& gl, const char* id, const ImVec2& size, ImGuiWindowFlags flags) {
  // Before the child is begun: ImGui may draw its border, too, into the list of the window that it is in. Sizes as ImGui takes them.
  const ImVec2 at = ImGui::GetCursorScreenPos(), room = ImGui::GetContentRegionAvail();
  const auto lengthOf = [](float asked, float available) {
    const float whole = std::floor(asked);
    return std::floor(whole > 0.0f ? whole : std::max(available + whole, 4.0f));
  };
  const ImVec2 from{std::floor(at.x), std::floor(at.y)};
  fill(*ImGui::GetWindowDrawList(), gl, from, {from.x + lengthOf(size.x, room.x), from.y + lengthOf(size.y, room.y)});
  ImGui::PushStyleColor(ImGuiCol_ChildBg, {0.0f, 0.0f, 0.0f, 0.0f});
  const bool isVisible = ImGui::BeginChild(id, size, true, flags);
  ImGui::PopStyleColor();
  return isVisible;
}

}  // namespace warpscope::ui
