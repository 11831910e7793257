// Lanes over one axis, the distance along the ray.
// See ray_view.h.
#include "app/ui/ray_view.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <vector>

#include "app/picture/plot_axis.h"
#include "app/ui/ground.h"
#include "render/base/formatted.h"

namespace warpscope::ui {
namespace {

constexpr float kLegendPx = 132.0f, kStripPx = 9.0f, kLanePx = 12.0f, kNearMarkerPx = 4.0f;  // at scale 1
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

/// What curves are drawn of, and what their tops stand for.
struct Tops {
  double lowest = 0.0, highest = 0.0;  ///< of values
  float mostOpaque = 0.0f;             ///< over a unit
};

Tops topsOf(const RayTrace& trace, const Span& span) {
  Tops tops{1e300, -1e300, 0.0f};
  for (const RayPlace& place : trace.places) {
    if (!std::isfinite(place.value)) continue;
    tops.lowest = std::min(tops.lowest, place.value), tops.highest = std::max(tops.highest, place.value);
    if (place.t >= span.begin && place.t <= span.end) tops.mostOpaque = std::max(tops.mostOpaque, place.look.a);
  }
  return tops;
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
    list->AddRect(from, to, ImGui::GetColorU32(palette().dimText));  // dark ones can be seen, too
  }
}

void drawCurves(const Lane& lane, const RayTrace& trace, const Tops& tops, const Look& look) {
  const float thickness = look.px(1.3f);
  const auto atPlace = [](const RayPlace& place) { return place.t; };
  if (tops.highest > tops.lowest)
    drawCurve(lane, trace.places, atPlace, [&](const RayPlace& place) { return static_cast<float>((place.value - tops.lowest) / (tops.highest - tops.lowest)); }, palette().dimText, thickness);
  if (tops.mostOpaque > 0.0f)
    drawCurve(lane, trace.places, atPlace, [&](const RayPlace& place) { return place.look.a / tops.mostOpaque; }, kOpacityColor, thickness);
  // What light is left behind each sample; between them it stays.
  std::vector<std::pair<float, float>> light{{lane.span.begin, 1.0f}};
  for (const CountingSample& sample : trace.samples) {
    light.emplace_back(sample.t, sample.transmittance);
    light.emplace_back(sample.t, 1.0f - sample.accumulatedAfter());
  }
  if (!trace.isEnded) light.emplace_back(lane.span.end, light.back().second);
  drawCurve(lane, light, [](const auto& one) { return one.first; }, [](const auto& one) { return one.second; }, kLightColor, thickness);
}

/// The ray's depths, near to far.
std::vector<TracedDepth> depthsAlong(const RayTrace& trace) {
  std::vector<TracedDepth> depths = trace.depths;
  std::erase_if(depths, [](const TracedDepth& depth) { return !depth.result.hasDepth; });
  std::ranges::stable_sort(depths, {}, [](const TracedDepth& depth) { return depth.result.depth; });
  return depths;
}

std::string textOf(const TracedDepth& depth, float fromEye) { return std::string(nameOf(depth.heuristic)) + " " + formatted("%.4g", fromEye + depth.result.depth); }

/// Each a marker in the drawing and a row at its right, as far as there is room: the one in use first of all, and at the end how many more there are. `fromEye`: of the
/// ray's beginning.
void drawDepths(const Lane& lane, std::span<const TracedDepth> depths, Heuristic used, float fromEye, const ImVec2& legendAt, float legendHeight, const Look& look) {
  ImDrawList* list = ImGui::GetWindowDrawList();
  ImVec2 at = legendAt;
  const float line = ImGui::GetTextLineHeight();
  auto rowsLeft = static_cast<size_t>(std::max(0.0f, (legendHeight + look.px(1.0f)) / (line + look.px(1.0f))));
  const bool areAllThere = depths.size() <= rowsLeft;
  if (!areAllThere && rowsLeft > 0) --rowsLeft;
  bool isUsedToCome = std::ranges::any_of(depths, [&](const TracedDepth& depth) { return depth.heuristic == used; });
  std::string others;
  for (const TracedDepth& depth : depths) {
    const bool isUsed = depth.heuristic == used;
    const bool hasRow = isUsed ? rowsLeft > 0 : rowsLeft > (isUsedToCome ? 1u : 0u);
    isUsedToCome &= !isUsed;
    const bool isPointedAt = hasRow && ImGui::IsMouseHoveringRect(at, {at.x + look.px(kLegendPx), at.y + line});
    const ImU32 color = ImGui::GetColorU32(isPointedAt ? ImGui::GetStyleColorVec4(ImGuiCol_Text) : isUsed ? palette().accent : palette().dimText);
    const float x = lane.x(depth.result.depth);
    list->AddLine({x, lane.from.y}, {x, lane.to.y}, color, look.px(isUsed || isPointedAt ? 2.0f : 1.0f));
    if (!hasRow) {
      others += (others.empty() ? "" : "\n") + textOf(depth, fromEye);
      continue;
    }
    --rowsLeft;
    list->AddText(at, color, std::string(nameOf(depth.heuristic)).c_str());
    list->AddText({at.x + look.px(82.0f), at.y}, color, formatted("%.4g", fromEye + depth.result.depth).c_str());
    if (isPointedAt) {
      ImGui::BeginTooltip();
      ImGui::TextUnformatted((std::string(nameOf(depth.heuristic)) + ": " + std::string(std::ranges::find(kHeuristics, depth.heuristic, &NamedValue<Heuristic>::value)->summary) + ".").c_str());
      ImGui::EndTooltip();
    }
    at.y += line + look.px(1.0f);
  }
  if (others.empty() || legendHeight < line) return;
  list->AddText(at, ImGui::GetColorU32(palette().faintText), ("and " + std::to_string(std::ranges::count(others, '\n') + 1) + " more").c_str());
  if (!ImGui::IsMouseHoveringRect(at, {at.x + look.px(kLegendPx), at.y + line})) return;
  ImGui::BeginTooltip();
  ImGui::TextUnformatted(others.c_str());
  ImGui::EndTooltip();
}

void drawAxis(const Lane& lane, float fromEye, const Look& look) {
  AxisScale axis(false, lane.from.x, lane.to.x);
  axis.include(fromEye + lane.span.begin);
  axis.include(fromEye + lane.span.end);
  ImDrawList* list = ImGui::GetWindowDrawList();
  for (const double tick : axis.ticks()) {
    const float t = static_cast<float>(tick) - fromEye;
    if (t < lane.span.begin || t > lane.span.end) continue;
    const std::string text = tickText(tick);
    list->AddLine({lane.x(t), lane.from.y}, {lane.x(t), lane.to.y}, ImGui::GetColorU32(ImGuiCol_Border));
    const float x = lane.x(t) + look.px(2.0f);
    if (x + ImGui::CalcTextSize(text.c_str()).x <= lane.to.x) list->AddText({x, lane.to.y}, ImGui::GetColorU32(palette().faintText), text.c_str());
  }
}

/// Of the place under the pointer.
void drawReading(const Lane& lane, const RayTrace& trace, std::span<const TracedDepth> depths, float fromEye, const Look& look) {
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
  ImGui::TextUnformatted(("depth " + formatted("%.4g", fromEye + place->t)).c_str());
  ImGui::TextUnformatted(("value " + formatted("%.4g", place->value)).c_str());
  ImGui::TextUnformatted(("opacity " + formatted("%.3g", place->look.a) + " over a unit").c_str());
  ImGui::TextUnformatted(("light left " + formatted("%.3g", left)).c_str());
  for (const TracedDepth& depth : depths)
    if (std::abs(lane.x(depth.result.depth) - ImGui::GetIO().MousePos.x) <= look.px(kNearMarkerPx))
      ImGui::TextColored(palette().accent, "%s", ("here: " + std::string(nameOf(depth.heuristic))).c_str());
  ImGui::EndTooltip();
}

std::string titleOf(const RayOfPixel& ray) {
  const std::string pixel = std::to_string(ray.pixel.x) + ", " + std::to_string(ray.pixel.y);
  return ray.isServers ? "Ray of the server's pixel " + pixel + ", which found the sample" : "Ray of the view's pixel " + pixel + ", which shows no sample";
}

/// Why one dot at the depth in use does not stand for the ray, if it does not.
std::string lightText(const RayResult& result, float fromEye) {
  const Heuristic used = result.job.settings.sample.heuristic;
  const std::optional<float> depth = depthBy(result.trace, used);
  if (!depth) return "Nothing on this ray counts.";
  const LightAbout light = lightAbout(result.trace, *depth);
  const auto percent = [](float share) { return formatted("%.0f %%", 100.0 * static_cast<double>(share)); };
  return "By " + std::string(nameOf(used)) + " the ray's dot stands " + formatted("%.4g", static_cast<double>(fromEye + *depth)) + " from the frame's eye: " + percent(light.within) + " of the light comes from within a voxel of it, " +
         percent(light.nearer) + " from nearer, " + percent(light.farther) + " from farther.";
}

/// What the frame has where that place is which it does not show.
std::string textOf(const SeenByFrame& seen) {
  const std::string pixel = "pixel " + std::to_string(seen.pixel.x) + ", " + std::to_string(seen.pixel.y), apart = formatted("%.3g", static_cast<double>(seen.apart)),
                    radius = formatted("%.3g", static_cast<double>(seen.radius));
  switch (seen.kind) {
    case SeenByFrame::Kind::outside: return "The frame's picture does not reach there.";
    case SeenByFrame::Kind::nothing: return "The frame's " + pixel + ", where that is, has no sample.";
    case SeenByFrame::Kind::nearer: return "From the frame's eye it was hidden: its " + pixel + " shows what lies " + apart + " nearer.";
    case SeenByFrame::Kind::farther: return "The frame's " + pixel + ", where that is, has its sample " + apart + " farther: the depth stands for something else.";
    case SeenByFrame::Kind::there: break;
  }
  return "The frame's " + pixel + " has a sample there, " + apart + " away and of radius " + radius + ": it does not cover this pixel.";
}

/// Why the frame shows nothing where the ray is.
std::string gapText(const RayResult& result, float fromEye) {
  if (!result.seen) return "Nothing on this ray counts: in truth it shows the background, too.";
  const float depth = *depthBy(result.trace, result.job.settings.sample.heuristic);
  return "What it shows in truth is " + formatted("%.4g", static_cast<double>(fromEye + depth)) + " from the eye. " + textOf(*result.seen);
}

/// Why the pixel shows a sample that is not what it shows in truth.
std::string missedText(const MissedPlace& missed) {
  const std::string depth = formatted("%.4g", static_cast<double>(missed.depth)), apart = formatted("%.3g", static_cast<double>(std::abs(missed.before)));
  return (missed.before > 0.0f ? "One looks through a gap here: what this pixel shows in truth is " + depth + " from the eye, " + apart + " in front of the sample. "
                               : "Something else is in front here: what this pixel shows in truth is " + depth + " from the eye, " + apart + " behind the sample. ") +
         textOf(missed.seen);
}

struct CurveKey {
  std::string text;
  ImVec4 color;
};

std::array<CurveKey, 3> keyOfCurves(const Tops& tops) {
  const bool hasValues = tops.highest > tops.lowest;
  return {{{hasValues ? "value " + formatted("%.4g", tops.lowest) + " to " + formatted("%.4g", tops.highest) : "value", palette().dimText},
           {"opacity 0 to " + formatted("%.3g", static_cast<double>(tops.mostOpaque)), kOpacityColor},
           {"light left 0 to 1", kLightColor}}};
}

/// Draws it where there is a list, which begins at `at`. Returns where it ends.
float drawKey(ImDrawList* list, ImVec2 at, std::span<const CurveKey> key) {
  float end = at.x;
  for (const CurveKey& one : key) {
    if (list != nullptr) list->AddText(at, ImGui::GetColorU32(one.color), one.text.c_str());
    end = at.x + ImGui::CalcTextSize(one.text.c_str()).x;
    at.x = end + ImGui::CalcTextSize("   ").x;
  }
  return end;
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
  const float fromEye = hasTrace ? glm::length(ray.result()->trace.ray.origin - ray.result()->job.ray.camera.eye) : 0.0f;
  if (hasTrace && (ray.result()->job.ray.isServers || ray.result()->job.frame)) {
    const RayResult& result = *ray.result();
    ImGui::PushTextWrapPos(0.0f);
    ImGui::TextUnformatted((result.missed ? missedText(*result.missed) : result.job.ray.isGap ? gapText(result, fromEye) : lightText(result, fromEye)).c_str());
    ImGui::PopTextWrapPos();
  }
  const ImVec2 at = ImGui::GetCursorScreenPos(), room = ImGui::GetContentRegionAvail();
  const float line = ImGui::GetTextLineHeight(), gap = look.px(3.0f);
  const bool hasLegend = room.x > look.px(kLegendPx + 160.0f);
  const float width = room.x - (hasLegend ? look.px(kLegendPx) : 0.0f), bottom = at.y + room.y - 2.0f * line;
  if (hasTrace && room.y > look.px(56.0f) && width > look.px(40.0f)) {
    const RayResult& result = *ray.result();
    const Span span = spanOf(result.trace);
    const Tops tops = topsOf(result.trace, span);
    const std::vector<TracedDepth> depths = depthsAlong(result.trace);
    const Lane strip{at, {at.x + width, at.y + look.px(kStripPx)}, span};
    const Lane segments{{at.x, bottom - look.px(kLanePx)}, {at.x + width, bottom}, span};
    const Lane curves{{at.x, strip.to.y + gap}, {at.x + width, segments.from.y - gap}, span};
    ImDrawList* list = ImGui::GetWindowDrawList();
    fillGround(*list, *look.gl, curves.from, curves.to, ImGuiCol_WindowBg, 0.0f);
    ImGui::InvisibleButton("along the ray", {width, bottom - at.y});
    list->PushClipRect(at, {at.x + width, bottom}, true);
    drawStrip(strip, result.trace);
    drawCurves(curves, result.trace, tops, look);
    drawSegments(segments, result.trace);
    list->PopClipRect();
    drawAxis({curves.from, segments.to, span}, fromEye, look);
    // Where it is narrow the curves' key takes the last row beside it as well.
    const std::array<CurveKey, 3> key = keyOfCurves(tops);
    const ImVec2 legendAt(at.x + width + look.px(8.0f), at.y);
    const bool isKeyWide = drawKey(nullptr, at, key) > legendAt.x - look.px(4.0f);
    drawDepths(curves, depths, result.job.settings.sample.heuristic, fromEye, legendAt, room.y - (isKeyWide ? line : 0.0f), look);
    drawReading({curves.from, segments.to, span}, result.trace, depths, fromEye, look);
    drawKey(list, {at.x, bottom + line}, key);
  }
  ImGui::PopFont();
  return !isClosed;
}

}  // namespace warpscope::ui
