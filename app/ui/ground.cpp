// By clears of the scissor's rectangle, but for the round corners.
// See ground.h.
#include "app/ui/ground.h"

#include <algorithm>
#include <cmath>

namespace warpscope::ui {
namespace {

/// What ImGui's backend calls amidst its commands; each sets the scissor itself. The command's clip rectangle is what is cleared.
template <ImGuiCol kColor>
void clear(const ImDrawList* /*list*/, const ImDrawCmd* command) {
  const WindowGl& gl = *static_cast<const WindowGl*>(command->UserCallbackData);
  const ImDrawData& display = *ImGui::GetDrawData();
  const ImVec2 scale = display.FramebufferScale, origin = display.DisplayPos;
  const ImVec4& clip = command->ClipRect;
  const int left = static_cast<int>(std::lround((clip.x - origin.x) * scale.x)), right = static_cast<int>(std::lround((clip.z - origin.x) * scale.x));
  const int top = static_cast<int>(std::lround((clip.y - origin.y) * scale.y)), bottom = static_cast<int>(std::lround((clip.w - origin.y) * scale.y));
  const int height = static_cast<int>(std::lround(display.DisplaySize.y * scale.y));
  if (left >= right || top >= bottom) return;
  const ImVec4& color = ImGui::GetStyle().Colors[kColor];
  gl.scissor(left, height - bottom, right - left, bottom - top);
  gl.clearColor(color.x, color.y, color.z, 1.0f);
  gl.clear(GL_COLOR_BUFFER_BIT);
}

}  // namespace

void fillGround(ImDrawList& list, const WindowGl& gl, const ImVec2& begin, const ImVec2& end, ImGuiCol color, float rounding) {
  // Between pixels nothing is cleared: corners that are smoothed there would not meet it.
  const ImVec2 scale = ImGui::GetIO().DisplayFramebufferScale;
  const auto snapped = [&](const ImVec2& at) { return ImVec2{std::round(at.x * scale.x) / scale.x, std::round(at.y * scale.y) / scale.y}; };
  const ImVec2 from = snapped(begin), to = snapped(end);
  const float corner = std::ceil(rounding * scale.x) / scale.x;
  const ImVec2 innerFrom{from.x + corner, from.y + corner}, innerTo{to.x - corner, to.y - corner};
  if (innerFrom.x >= innerTo.x || innerFrom.y >= innerTo.y) return list.AddRectFilled(from, to, ImGui::GetColorU32(color), rounding);
  const auto fill = [&](const ImVec2& upper, const ImVec2& lower) {
    list.PushClipRect(upper, lower, true);
    list.AddCallback(color == ImGuiCol_ChildBg ? clear<ImGuiCol_ChildBg> : clear<ImGuiCol_WindowBg>, const_cast<WindowGl*>(&gl));
    list.PopClipRect();
  };
  fill({innerFrom.x, from.y}, {innerTo.x, to.y});
  if (corner == 0.0f) return;
  fill({from.x, innerFrom.y}, {innerFrom.x, innerTo.y});
  fill({innerTo.x, innerFrom.y}, {to.x, innerTo.y});
  const ImU32 filled = ImGui::GetColorU32(color);
  list.AddRectFilled(from, innerFrom, filled, rounding, ImDrawFlags_RoundCornersTopLeft);
  list.AddRectFilled({innerTo.x, from.y}, {to.x, innerFrom.y}, filled, rounding, ImDrawFlags_RoundCornersTopRight);
  list.AddRectFilled({from.x, innerTo.y}, {innerFrom.x, to.y}, filled, rounding, ImDrawFlags_RoundCornersBottomLeft);
  list.AddRectFilled(innerTo, to, filled, rounding, ImDrawFlags_RoundCornersBottomRight);
}

bool beginChildOnGround(const WindowGl& gl, const char* id, const ImVec2& size, ImGuiWindowFlags flags) {
  // Before the child is begun: ImGui may draw its border, too, into the list of the window that it is in. Sizes as ImGui takes them.
  const ImVec2 at = ImGui::GetCursorScreenPos(), room = ImGui::GetContentRegionAvail();
  const auto lengthOf = [](float asked, float available) {
    const float whole = std::floor(asked);
    return std::floor(whole > 0.0f ? whole : std::max(available + whole, 4.0f));
  };
  const ImVec2 from{std::floor(at.x), std::floor(at.y)};
  fillGround(*ImGui::GetWindowDrawList(), gl, from, {from.x + lengthOf(size.x, room.x), from.y + lengthOf(size.y, room.y)}, ImGuiCol_ChildBg, ImGui::GetStyle().ChildRounding);
  ImGui::PushStyleColor(ImGuiCol_ChildBg, {0.0f, 0.0f, 0.0f, 0.0f});
  const bool isVisible = ImGui::BeginChild(id, size, true, flags);
  ImGui::PopStyleColor();
  return isVisible;
}

}  // namespace warpscope::ui
