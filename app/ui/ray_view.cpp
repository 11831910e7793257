// Lanes over one axis, the distance along the ray.
// See ray_view.h.
#include "app/ui/ray_view.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "app/picture/plot_axis.h"
#include "render/base/formatted.h"

namespace warpscope::ui {
namespace {

constexpr float kLegendPx = 132.0f, kStripPx = 9.0f, kLanePx = 12.0f;  // at scale 1
const ImVec4 kOpacityColor{0.95f, 0.62f, 0.25f, 1.0f}, kLightColor{0.35f, 0.70f, 0.95f, 1.0f};

/// The part of the ray that is worth showing: where samples count and a little about it, or all of it where none does.
struct Span {
  float begin = 0.0f, end = 1.0f;
  float share(float t) const { return (t - begin) / (end - begin); }
};

Span spanOf(const RayTrace& trace) {
  if (trace.samples.empty()) return {trace.begin, std::max(trace.end, std::nextafter(trace.begin, 1e30f))};
  const float first = trace.samples.front().t, last = trace.samples.back().t;
  const float margin = 0.08f * (last - first) + 2.0f * trace.samples.front().ds;
  return {std::max(trace.begin, first - margin), std::min(trace.end, last + margin)};
}

/// A lane of the drawing.
struct Lane {
  ImVec2 from, to;
  Span span;
  float x(float t) const { return from.x + (to.x - from.x) * span.share(t); }
  float y(float share) const { return to.y - (to.y - from.y) * std::clamp(share, 0.0f, 1.0f); }
};

template <class Points, class At, class Share>
void drawCurve(const Lane& lane, const Points& points, const At& at, const Share& share, const ImVec4& color, float thickness) {
  std::vector<ImVec2> line;
  ImDrawList* list = ImGui::GetWindowDrawList();
  const auto flush = [&] {
    if (line.size() > 1) list->AddPolyline(line.data(), static_cast<int>(line.size()), ImGui::GetColorU32(color), 0, thickness);
    line.clear();
  };
  for (const auto& point : points) {
    const float height = share(point);
    if (!std::isfinite(height) || at(point) < lane.span.begin || at(point) > lane.span.end)
      flush();
    else
      line.push_back({lane.x(at(point)), lane.y(height)});
  }
  flush();
}

/// What the transfer function makes of the values.
void drawStrip(const Lane& lane, const RayTrace& trace) {
  ImDrawList* list = ImGui::GetWindowDrawList();
  list->AddRectFilled(lane.from, lane.to, IM_COL32(0, 0, 0, 255));
  for (size_t i = 0; i + 1 < trace.places.size(); ++i) {
    const RayPlace &place = trace.places[i], &next = trace.places[i + 1];
    if (!std::isfinite(place.value) || next.t < lane.span.begin || place.t > lane.span.end || place.look.a <= 0.0f) continue;
    const float opacity = std::sqrt(std::min(1.0f, place.look.a));  // faint ones can be seen, too
    list->AddRectFilled({lane.x(std::max(place.t, lane.span.begin)), lane.from.y}, {lane.x(std::min(next.t, lane.span.end)) + 0.5f, lane.to.y},
                        screenColor(glm::vec3(place.look), opacity));
  }
}

void drawSegments(const Lane& lane, const RayTrace& trace) {
  ImDrawList* list = ImGui::GetWindowDrawList();
  for (const RaySegment& segment : trace.segments) {
    if (!(segment.opacity > 0.0f)) continue;
    const ImVec2 from{lane.x(std::max(segment.begin, lane.span.begin)), lane.y(std::sqrt(segment.opacity))};
    const ImVec2 to{std::max(lane.x(std::min(segment.end, lane.span.end)), from.x + 1.0f), lane.to.y};
    list->AddRectFilled(from, to, screenColor(segment.color / segment.opacity));
    list->AddRect(from, to, IM_COL32(0, 0, 0, 160));
  }
}

void drawCurves(const Lane& lane, const RayTrace& trace, const Look& look) {
  double lowest = 1e300, highest = -1e300;
  float mostOpaque = 0.0f;
  for (const RayPlace& place : trace.places) {
    if (!std::isfinite(place.value)) continue;
    lowest = std::min(lowest, place.value), highest = std::max(highest, place.value);
    if (place.t >= lane.span.begin && place.t <= lane.span.end) mostOpaque = std::max(mostOpaque, place.look.a);
  }
  const float thickness = look.px(1.3f);
  const auto atPlace = [](const RayPlace& place) { return place.t; };
  if (highest > lowest)
    drawCurve(lane, trace.places, atPlace, [&](const RayPlace& place) { return static_cast<float>((place.value - lowest) / (highest - lowest)); }, palette().dimText, thickness);
  if (mostOpaque > 0.0f)
    drawCurve(lane, trace.places, atPlace, [&](const RayPlace& place) { return place.look.a / mostOpaque; }, kOpacityColor, thickness);
  // What light is left behind each sample; between them it stays.
  std::vector<std::pair<float, float>> light{{lane.span.begin, 1.0f}};
  for (const CountingSample& sample : trace.samples) {
    light.emplace_back(sample.t, sample.transmittance);
    light.emplace_back(sample.t, 1.0f - sample.accumulatedAfter());
  }
  if (!trace.isEnded) light.emplace_back(lane.span.end, light.back().second);
  drawCurve(lane, light, [](const auto& one) { return one.first; }, [](const auto& one) { return one.second; }, kLightColor, thickness);
}

/// The ray's depths, near to far, at its right; each a marker in the drawing.
void drawDepths(const Lane& lane, const RayTrace& trace, Heuristic used, const ImVec2& legendAt, const Look& look) {
  std::vector<TracedDepth> depths = trace.depths;
  std::erase_if(depths, [](const TracedDepth& depth) { return !depth.result.hasDepth; });
  std::ranges::stable_sort(depths, {}, [](const TracedDepth& depth) { return depth.result.depth; });
  ImDrawList* list = ImGui::GetWindowDrawList();
  ImVec2 at = legendAt;
  const float line = ImGui::GetTextLineHeight();
  for (const TracedDepth& depth : depths) {
    const bool isUsed = depth.heuristic == used, isPointedAt = ImGui::IsMouseHoveringRect(at, {at.x + look.px(kLegendPx), at.y + line});
    const ImU32 color = ImGui::GetColorU32(isPointedAt ? ImGui::GetStyleColorVec4(ImGuiCol_Text) : isUsed ? palette().accent : palette().dimText);
    const float x = lane.x(depth.result.depth);
    list->AddLine({x, lane.from.y}, {x, lane.to.y}, color, look.px(isUsed || isPointedAt ? 2.0f : 1.0f));
    list->AddText(at, color, std::string(nameOf(depth.heuristic)).c_str());
    list->AddText({at.x + look.px(82.0f), at.y}, color, formatted("%.4g", depth.result.depth).c_str());
    at.y += line + look.px(1.0f);
  }
}

void drawAxis(const Lane& lane, const Look& look) {
  AxisScale axis(false, lane.from.x, lane.to.x);
  axis.include(lane.span.begin);
  axis.include(lane.span.end);
  ImDrawList* list = ImGui::GetWindowDrawList();
  for (const double tick : axis.ticks()) {
    const auto t = static_cast<float>(tick);
    if (t < lane.span.begin || t > lane.span.end) continue;
    const std::string text = tickText(tick);
    list->AddLine({lane.x(t), lane.from.y}, {lane.x(t), lane.to.y}, ImGui::GetColorU32(ImGuiCol_Border));
    list->AddText({lane.x(t) + look.px(2.0f), lane.to.y}, ImGui::GetColorU32(palette().faintText), text.c_str());
  }
}

/// Of the place under the pointer.
void drawReading(const Lane& lane, const RayTrace& trace, const Look& look) {
  if (!ImGui::IsItemHovered() || trace.places.empty()) return;
  const float share = (ImGui::GetIO().MousePos.x - lane.from.x) / (lane.to.x - lane.from.x);
  const float t = lane.span.begin + share * (lane.span.end - lane.span.begin);
  const auto place = std::ranges::min_element(trace.places, {}, [&](const RayPlace& one) { return std::abs(one.t - t); });
  float left = 1.0f;
  for (const CountingSample& sample : trace.samples)
    if (sample.t <= t) left = 1.0f - sample.accumulatedAfter();
  const float x = lane.x(place->t);
  ImGui::GetWindowDrawList()->AddLine({x, lane.from.y}, {x, lane.to.y}, ImGui::GetColorU32(ImGuiCol_Text), look.px(1.0f));
  ImGui::BeginTooltip();
  ImGui::TextUnformatted(("depth " + formatted("%.4g", place->t)).c_str());
  ImGui::TextUnformatted(("value " + formatted("%.4g", place->value)).c_str());
  ImGui::TextUnformatted(("opacity " + formatted("%.3g", place->look.a) + " over a unit").c_str());
  ImGui::TextUnformatted(("light left " + formatted("%.3g", left)).c_str());
  ImGui::EndTooltip();
}

std::string titleOf(const RayOfPixel& ray) {
  const std::string pixel = std::to_string(ray.pixel.x) + ", " + std::to_string(ray.pixel.y);
  return ray.isServers ? "Ray of the server's pixel " + pixel + ", which found the sample" : "Ray of the view's pixel " + pixel + ", which shows no sample";
}

void drawKeyOfCurves(ImVec2 at) {
  ImDrawList* list = ImGui::GetWindowDrawList();
  for (const auto& [text, color] : {std::pair{"value", palette().dimText}, {"opacity", kOpacityColor}, {"light left", kLightColor}}) {
    list->AddText(at, ImGui::GetColorU32(color), text);
    at.x += ImGui::CalcTextSize(text).x + ImGui::CalcTextSize("   ").x;
  }
}

}  // namespace

bool drawRay(const Session& session, const Look& look) {
  const LiveRay& ray = session.ray();
  ImGui::PushFont(look.fonts.small);
  const bool hasTrace = ray.error().empty() && ray.result();
  const std::string title = !ray.error().empty() ? ray.error() : hasTrace ? titleOf(ray.result()->job.ray) : "the ray is traced when the view rests";
  ImGui::TextColored(ray.error().empty() ? palette().dimText : palette().errorText, "%s", title.c_str());
  ImGui::SameLine(ImGui::GetWindowWidth() - look.px(24.0f));
  const bool isClosed = ImGui::SmallButton("x");
  tooltip("Close.", look);
  const ImVec2 at = ImGui::GetCursorScreenPos(), room = ImGui::GetContentRegionAvail();
  const float line = ImGui::GetTextLineHeight(), gap = look.px(3.0f);
  const bool hasLegend = room.x > look.px(kLegendPx + 160.0f);
  const float width = room.x - (hasLegend ? look.px(kLegendPx) : 0.0f), bottom = at.y + room.y - 2.0f * line;
  if (hasTrace && room.y > look.px(70.0f) && width > look.px(40.0f)) {
    const RayResult& result = *ray.result();
    const Span span = spanOf(result.trace);
    const Lane strip{at, {at.x + width, at.y + look.px(kStripPx)}, span};
    const Lane segments{{at.x, bottom - look.px(kLanePx)}, {at.x + width, bottom}, span};
    const Lane curves{{at.x, strip.to.y + gap}, {at.x + width, segments.from.y - gap}, span};
    ImDrawList* list = ImGui::GetWindowDrawList();
    list->AddRectFilled(curves.from, curves.to, ImGui::GetColorU32(palette().frame));
    ImGui::InvisibleButton("along the ray", {width, bottom - at.y});
    list->PushClipRect(at, {at.x + width, bottom}, true);
    drawStrip(strip, result.trace);
    drawCurves(curves, result.trace, look);
    drawSegments(segments, result.trace);
    list->PopClipRect();
    drawAxis({curves.from, segments.to, span}, look);
    drawDepths(curves, result.trace, result.job.settings.sample.heuristic, {at.x + width + look.px(8.0f), at.y}, look);
    drawReading({curves.from, segments.to, span}, result.trace, look);
    drawKeyOfCurves({at.x, bottom + line});
  }
  ImGui::PopFont();
  return !isClosed;
}

}  // namespace warpscope::ui
