// Where the time went that a picture on show is old by: one bar, a piece for each stage.
// See parts.h.
#include <array>

#include "app/ui/parts.h"

namespace warpscope::ui {
namespace {

struct Stage {
  const char* name;
  double ms;
  ImVec4 color;
};

/// From the moment that the frame was wanted. Warm: the network and waiting; cold: the server; green: this side.
std::array<Stage, 11> stagesOf(const Panel& panel) {
  const FrameLatency& latency = panel.latency;
  return {{{"waiting for requests before it", latency.waitMs, {0.52f, 0.38f, 0.22f, 1.0f}},
           {"wire, there and back", latency.wireMs, {0.85f, 0.56f, 0.25f, 1.0f}},
           {"queue at the server", latency.queueMs, {0.36f, 0.38f, 0.52f, 1.0f}},
           {"march", latency.marchMs, {0.35f, 0.52f, 0.85f, 1.0f}},
           {"compaction", latency.compactMs, {0.47f, 0.63f, 0.92f, 1.0f}},
           {"copy from the device", latency.copyMs, {0.58f, 0.72f, 0.95f, 1.0f}},
           {"encoding", latency.encodeMs, {0.56f, 0.48f, 0.82f, 1.0f}},
           {"decoding", latency.decodeMs, {0.70f, 0.60f, 0.90f, 1.0f}},
           {"build", panel.buildMs, {0.30f, 0.62f, 0.45f, 1.0f}},
           {"draw", panel.drawMs, {0.42f, 0.76f, 0.55f, 1.0f}},
           {"waiting for the display", panel.displayMs, {0.62f, 0.82f, 0.66f, 1.0f}}}};
}

/// What the colours stand for, and how long each took: beside the pointer, at once.
void drawKey(const std::array<Stage, 11>& stages, double totalMs, const Look& look) {
  ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {look.px(8.0f), look.px(6.0f)});
  ImGui::BeginTooltip();
  ImGui::Text("%s from the moment that this frame was wanted until it was on show", durationText(totalMs).c_str());
  const float line = ImGui::GetTextLineHeight();
  for (const Stage& stage : stages) {
    if (stage.ms < 0.005) continue;
    const ImVec2 at = ImGui::GetCursorScreenPos();
    ImGui::GetWindowDrawList()->AddRectFilled({at.x, at.y + 0.15f * line}, {at.x + 0.7f * line, at.y + 0.85f * line}, ImGui::GetColorU32(stage.color), look.px(2.0f));
    ImGui::Dummy({line, line});
    ImGui::SameLine();
    ImGui::TextUnformatted(durationText(stage.ms).c_str());
    ImGui::SameLine(look.px(106.0f));
    ImGui::TextUnformatted(stage.name);
  }
  ImGui::EndTooltip();
  ImGui::PopStyleVar();
}

}  // namespace

void drawTimeline(const Panel& panel, const Look& look) {
  const ImVec2 at = ImGui::GetCursorScreenPos();
  const ImVec2 size{ImGui::GetContentRegionAvail().x, look.px(kTimelinePx)};
  ImGui::InvisibleButton("timeline", size);
  ImDrawList* list = ImGui::GetWindowDrawList();
  list->AddRectFilled(at, {at.x + size.x, at.y + size.y}, ImGui::GetColorU32(ImGuiCol_FrameBg), look.px(2.0f));
  const bool usesFrame = panel.drawn != nullptr && panel.drawn->usesFrame;
  if (!usesFrame) {
    tooltip("Where the time goes from the moment that a frame is wanted until it is on show. This technique uses no frames.", look);
    return;
  }
  const std::array<Stage, 11> stages = stagesOf(panel);
  double totalMs = 0.0;
  for (const Stage& stage : stages) totalMs += stage.ms;
  float x = at.x;
  for (const Stage& stage : stages) {
    const float width = totalMs > 0.0 ? size.x * static_cast<float>(stage.ms / totalMs) : 0.0f;
    list->AddRectFilled({x, at.y}, {x + width, at.y + size.y}, ImGui::GetColorU32(stage.color));
    x += width;
  }
  if (ImGui::IsItemHovered()) drawKey(stages, totalMs, look);
}

}  // namespace warpscope::ui
