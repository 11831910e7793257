// Frame, ticks, points, pointer.
// See scatter_plot.h.
#include "app/ui/scatter_plot.h"

#include <cmath>
#include <limits>

#include "app/picture/plot_axis.h"
#include "app/ui/ground.h"
#include "app/ui/theme.h"

namespace warpscope::ui {
namespace {

constexpr float kRadiusPx = 4.0f, kRingPx = 7.5f, kReachPx = 12.0f;  // at scale 1
constexpr ImU32 kFaint = 80;  // of 255

/// The plot's frame: inside of it are points, left and beneath of it ticks and labels.
struct Frame {
  ImVec2 from, to;
};

ImVec2 sizeOf(const std::string& text, const ScatterLook& look) {
  return look.small->CalcTextSizeA(look.small->FontSize * ImGui::GetIO().FontGlobalScale, std::numeric_limits<float>::max(), 0.0f, text.c_str());
}

void drawText(ImDrawList& list, const ImVec2& at, const ImVec4& color, const std::string& text, const ScatterLook& look) {
  list.AddText(look.small, look.small->FontSize * ImGui::GetIO().FontGlobalScale, at, ImGui::GetColorU32(color), text.c_str());
}

/// Every tick has a line, those that have room a number as well.
void drawTicks(ImDrawList& list, const AxisScale& x, const AxisScale& y, const Frame& frame, const ScatterLook& look) {
  const ImU32 grid = ImGui::GetColorU32(palette().grid);
  const float gap = 4.0f * look.scale;
  float free = -std::numeric_limits<float>::max();
  const float end = frame.to.x - sizeOf(look.xLabel, look).x - 2.0f * gap;  // the axis's name stands there
  for (const double tick : x.ticks()) {
    const float at = static_cast<float>(x.place(tick));
    list.AddLine({at, frame.from.y}, {at, frame.to.y}, grid);
    const std::string text = tickText(tick);
    const float width = sizeOf(text, look).x;
    if (at - 0.5f * width < free || at + 0.5f * width > end) continue;
    drawText(list, {at - 0.5f * width, frame.to.y + gap}, palette().dimText, text, look);
    free = at + 0.5f * width + 2.0f * gap;
  }
  free = std::numeric_limits<float>::max();
  const float highest = frame.from.y + sizeOf(look.yLabel, look).y;
  for (const double tick : y.ticks()) {
    const float at = static_cast<float>(y.place(tick));
    list.AddLine({frame.from.x, at}, {frame.to.x, at}, grid);
    const std::string text = tickText(tick);
    const ImVec2 extent = sizeOf(text, look);
    if (at + 0.5f * extent.y > free || at - 0.5f * extent.y < highest) continue;
    drawText(list, {frame.from.x - gap - extent.x, at - 0.5f * extent.y}, palette().dimText, text, look);
    free = at - 0.5f * extent.y;
  }
  drawText(list, {frame.to.x - sizeOf(look.xLabel, look).x, frame.to.y + gap}, palette().dimText, look.xLabel, look);
  drawText(list, {frame.from.x - gap - sizeOf(look.yLabel, look).x, frame.from.y}, palette().dimText, look.yLabel, look);
}

void drawPoint(ImDrawList& list, const ScatterPoint& point, const ImVec2& at, bool isHovered, const ScatterLook& look) {
  const float radius = (isHovered ? 1.3f : 1.0f) * kRadiusPx * look.scale, line = 1.4f * look.scale;
  if (point.isOnFront) list.AddCircle(at, kRingPx * look.scale, ImGui::GetColorU32(ImGuiCol_Text, 0.75f), 0, 1.2f * look.scale);
  const ImU32 color = point.isDim ? (point.color & ~IM_COL32_A_MASK) | kFaint << IM_COL32_A_SHIFT : point.color;
  if (point.isHollow) {
    list.AddCircle(at, radius, color, 0, line);
    return;
  }
  list.AddCircleFilled(at, radius, color);
  if (point.isMarked) list.AddCircle(at, radius, ImGui::GetColorU32(ImGuiCol_Text), 0, line);
}

/// Returns the point that is pointed at there, if one is.
std::optional<size_t> drawLegend(ImDrawList& list, const Frame& frame, const ScatterLook& look) {
  const ImVec2 pointer = ImGui::GetIO().MousePos;
  std::optional<size_t> pointedAt;
  const float line = sizeOf("0", look).y, gap = 4.0f * look.scale;
  ImVec2 at{frame.to.x - gap, frame.from.y + gap};
  for (const ScatterLook::Entry& entry : look.legend) {
    if (at.y + line > frame.to.y) break;
    const float left = at.x - sizeOf(entry.name, look).x;
    drawText(list, {left, at.y}, palette().dimText, entry.name, look);
    list.AddCircleFilled({left - 2.0f * gap, at.y + 0.5f * line}, kRadiusPx * look.scale, entry.color);
    if (pointer.x >= left - 4.0f * gap && pointer.x <= frame.to.x && pointer.y >= at.y && pointer.y < at.y + line) pointedAt = entry.point;
    at.y += line;
  }
  return pointedAt;
}

void showLabel(const std::string& label, const ScatterLook& look) {
  ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {8.0f * look.scale, 6.0f * look.scale});
  ImGui::BeginTooltip();
  ImGui::TextUnformatted(label.c_str());
  ImGui::EndTooltip();
  ImGui::PopStyleVar();
}

}  // namespace

ScatterAnswer drawScatterPlot(const char* id, std::span<const ScatterPoint> points, const ImVec2& size, const ScatterLook& look) {
  const ImVec2 origin = ImGui::GetCursorScreenPos();
  ImGui::InvisibleButton(id, size);
  const bool isPointedAt = ImGui::IsItemHovered(), isPressed = isPointedAt && ImGui::IsMouseClicked(ImGuiMouseButton_Left);
  const float tickRoom = sizeOf("0.0005", look).x + 8.0f * look.scale, lineRoom = sizeOf("0", look).y + 6.0f * look.scale;
  const Frame frame{{origin.x + tickRoom, origin.y}, {origin.x + size.x, origin.y + size.y - lineRoom}};
  ImDrawList& list = *ImGui::GetWindowDrawList();
  fillGround(list, *look.gl, frame.from, frame.to, ImGuiCol_WindowBg, 3.0f * look.scale);

  ScatterAnswer answer;
  if (points.empty()) {
    const ImVec2 extent = sizeOf(look.emptyText, look);
    drawText(list, {0.5f * (frame.from.x + frame.to.x - extent.x), 0.5f * (frame.from.y + frame.to.y - extent.y)}, palette().dimText, look.emptyText, look);
    return answer;
  }
  AxisScale x(true, frame.from.x, frame.to.x), y(true, frame.to.y, frame.from.y);
  for (const ScatterPoint& point : points) {
    x.include(point.x);
    y.include(point.y);
  }
  x.settle();
  y.settle();
  drawTicks(list, x, y, frame, look);
  const std::optional<size_t> ofLegend = drawLegend(list, frame, look);

  const auto placeOf = [&](const ScatterPoint& point) { return ImVec2(static_cast<float>(x.place(point.x)), static_cast<float>(y.place(point.y))); };
  const ImVec2 pointer = ImGui::GetIO().MousePos;
  float nearest = kReachPx * look.scale;
  for (size_t i = 0; isPointedAt && i < points.size(); ++i) {
    if (!std::isfinite(points[i].x) || !std::isfinite(points[i].y)) continue;
    const ImVec2 at = placeOf(points[i]);
    const float distance = std::hypot(at.x - pointer.x, at.y - pointer.y);
    if (distance > nearest) continue;
    nearest = distance;
    answer.hovered = i;
  }
  if (isPointedAt && !answer.hovered) answer.hovered = ofLegend;
  if (isPressed) answer.clicked = answer.hovered;

  list.PushClipRect({frame.from.x - kRingPx * look.scale, frame.from.y}, {frame.to.x, frame.to.y + kRingPx * look.scale}, true);
  const auto layerOf = [](const ScatterPoint& point) { return point.isMarked ? 2 : point.isDim ? 0 : 1; };
  for (int layer = 0; layer <= 2; ++layer)
    for (size_t i = 0; i < points.size(); ++i)
      if (layerOf(points[i]) == layer && std::isfinite(points[i].x) && std::isfinite(points[i].y))
        drawPoint(list, points[i], placeOf(points[i]), answer.hovered == i, look);
  list.PopClipRect();
  if (answer.hovered) showLabel(points[*answer.hovered].label, look);
  return answer;
}

}  // namespace warpscope::ui
