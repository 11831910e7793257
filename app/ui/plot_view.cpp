// Points from the session and from a sweep, and the list of those that nothing beats.
// See plot_view.h.
#include "app/ui/plot_view.h"

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <vector>

#include "app/experiment/csv.h"
#include "app/picture/technique_color.h"
#include "app/ui/scatter_plot.h"

namespace warpscope::ui {
namespace {

constexpr float kPlotPx = 150.0f, kListPx = 330.0f, kLeastForListPx = 640.0f;  // at scale 1
constexpr float kLeastBodyPx = 480.0f;                                         // below it the plot stays folded up

constexpr std::string_view kHelp =
    "One point for each combination of technique and knobs that was on show while the view rested: milliseconds to decode, build and draw, and "
    "FLIP. Points are compared at the angles between frame and view that they have in common: mean FLIP, and the slowest view. Faint: not compared, "
    "because it was not seen at these angles or at this size of the pictures. Rings: nothing is faster and better. White rims: on show now. Drop a "
    "sweep.json onto the window for hollow points. Forgotten with another scene.";

ImU32 colorOf(const WarpDescriptor& technique) {
  const uint32_t rgb = techniqueRgb(technique);
  return IM_COL32(rgb >> 16 & 255, rgb >> 8 & 255, rgb & 255, 255);
}

std::string formatted(const char* pattern, double a, double b) {
  char text[64];
  std::snprintf(text, sizeof text, pattern, a, b);
  return text;
}

std::string figures(double frameMs, double flip) { return durationText(frameMs) + " a frame, FLIP " + formatted("%.4f", flip, 0.0); }

/// What tells it from others, whatever others there are.
std::string describe(const Configuration& configuration) {
  std::string text = labelOf(configuration) + othersOf(configuration) + "\nstep " + formatted("%.3g", configuration.march.render.step, 0.0);
  if (configuration.technique->usesFrame)
    text += ", server's image of " + std::to_string(configuration.serverSidePx) + " px, " + codecWord(configuration.codec);
  return text;
}

/// Of Shown::sources, for a legend.
std::string_view meaningOf(std::string_view source) {
  if (source == "measured") return "measured";
  return source == "seen" ? "seen while looking around" : "of the sweep";
}

std::string sizeField(uint32_t pixels) { return pixels == 0 ? "" : std::to_string(pixels); }

constexpr std::string_view kOfSweep = "sweep";

std::string angleCount(size_t count) { return std::to_string(count) + (count == 1 ? " angle" : " angles"); }

/// At which angles between frame and view what is compared was seen.
std::string comparedAt(const Session& session) {
  constexpr size_t kMostAnglesNamed = 3;
  if (!session.fair().points().empty()) return formatted(", mean of %g° to %g°", kFairAnglesDeg.front(), kFairAnglesDeg.back());
  const std::vector<double>& seenDeg = session.liveFront().rankedAnglesDeg();
  if (seenDeg.size() > kMostAnglesNamed) return ", at " + angleCount(seenDeg.size());
  std::string text;
  for (const double fromDeg : seenDeg) text += (text.empty() ? ", at " : ", ") + formatted("%g°", fromDeg, 0.0);
  return text;
}

/// The view on show, where the figures are of others; else nothing.
std::string viewApart(const Session& session, size_t panel) {
  const std::optional<double> angleDeg = session.angleDeg(panel);
  if (!angleDeg) return "";
  const auto isOfView = [&](double fromDeg) { return LiveFront::bucketOf(fromDeg) == LiveFront::bucketOf(*angleDeg); };
  if (session.fair().points().empty() && std::ranges::any_of(session.liveFront().rankedAnglesDeg(), isOfView)) return "";
  return formatted("this view is %.3g° from its frame", *angleDeg, 0.0);
}

/// Where a point stands among the others, and why.
std::string standingOf(const LiveFront::Point& point, const std::vector<double>& rankedDeg) {
  switch (point.standing) {
    case LiveFront::Standing::ranked: return "Mean of " + angleCount(rankedDeg.size()) + ", which all that are compared have in common.";
    case LiveFront::Standing::otherSize:
      return "Not compared: measured on pictures of " + std::to_string(point.pictureSize.x) + " x " + std::to_string(point.pictureSize.y) +
             " pixels.\nIt is again where pictures have that size.";
    case LiveFront::Standing::otherAngles: break;
  }
  if (rankedDeg.empty()) return "Not compared: no two were seen at the same angle yet.";
  std::string missing;
  for (const double fromDeg : rankedDeg)
    if (std::none_of(point.buckets.begin(), point.buckets.end(), [&](const LiveFront::Bucket& bucket) { return bucket.fromDeg == fromDeg; }))
      missing += (missing.empty() ? "" : ", ") + formatted("%g°", fromDeg, 0.0);
  return "Not compared: the others were seen at " + missing + " as well.\nIt is once it has rested there too: freeze (F), turn, wait.";
}

std::string describe(const LiveFront::Point& point, const std::vector<double>& rankedDeg) {
  std::string text = describe(point.configuration) + "\n" + figures(point.frameMs, point.flip);
  for (const LiveFront::Bucket& bucket : point.buckets)
    text += formatted("\n  FLIP %.4f at %g", bucket.flip, bucket.fromDeg) + formatted("° to %g°", bucket.fromDeg + LiveFront::kBucketDeg, 0.0) + ", " +
            durationText(bucket.frameMs);
  return text + "\n" + standingOf(point, rankedDeg);
}

/// As much of it as the width has room for, and that there is more.
std::string fitting(const std::string& text, float width) {
  constexpr const char* kMore = "...";
  if (ImGui::CalcTextSize(text.c_str()).x <= width) return text;
  std::string fits = text;
  while (!fits.empty() && ImGui::CalcTextSize((fits + kMore).c_str()).x > width) {
    do fits.pop_back();
    while (!fits.empty() && (static_cast<unsigned char>(fits.back()) & 0xc0) == 0x80);  // of a character's bytes all or none
  }
  return fits + kMore;
}

}  // namespace

/// Points of the plot and the configurations that they stand for.
struct PlotView::Shown {
  std::vector<ScatterPoint> points;
  std::vector<const Configuration*> configurations;
  std::vector<std::string_view> sources;  ///< "measured", "seen" or kOfSweep
  std::vector<std::string> angles;     ///< degrees between frame and view, "0 5 10"; buckets by their lower ends; empty where it is not known
  std::vector<glm::uvec2> sizes;       ///< of the pictures; 0 where it is not known
  std::vector<size_t> front;  ///< indices into all of them, the live ones first

  /// Each technique once, with a point of it: one that nothing beats, if there is one.
  std::vector<ScatterLook::Entry> legend() const {
    std::vector<ScatterLook::Entry> entries;
    const auto add = [&](size_t point) {
      const WarpDescriptor& technique = *configurations[point]->technique;
      if (std::ranges::find(entries, technique.label, &ScatterLook::Entry::name) == entries.end()) entries.push_back({std::string(technique.label), colorOf(technique), point});
    };
    for (const size_t point : front) add(point);
    for (size_t point = 0; point < points.size(); ++point) add(point);
    return entries;
  }
};

float PlotView::height(float bodyHeight, const Look& look) const {
  const float header = ImGui::GetFrameHeight() + 2.0f * look.px(8.0f);
  const bool hasRoom = bodyHeight >= look.px(kLeastBodyPx);
  return isUnfolded_ && hasRoom ? header + look.px(6.0f + kPlotPx) : header;
}

void PlotView::showSweep(SweepFile sweep) {
  sweep_ = std::move(sweep);
  error_.clear();
}

PlotView::Shown PlotView::shownOf(const Session& session, size_t panel) const {
  Shown shown;
  const std::string click = session.panelCount() > 1 ? "\nClick to show it in panel " + std::to_string(panel + 1) + ", which was used last." : "\nClick to show it.";
  const auto add = [&](std::string_view source, const Configuration& configuration, double frameMs, double flip, const std::string& text, const std::string& angles, const glm::uvec2& size) {
    ScatterPoint point;
    point.x = frameMs;
    point.y = flip;
    point.color = colorOf(*configuration.technique);
    point.label = text + click;
    shown.points.push_back(std::move(point));
    shown.configurations.push_back(&configuration);
    shown.sources.push_back(source);
    shown.angles.push_back(angles);
    shown.sizes.push_back(size);
  };
  const LiveFront& live = session.liveFront();
  const FairMeasuring& fair = session.fair();
  for (const FairPoint& point : fair.points()) {
    std::string text = describe(point.configuration) + "\n" + figures(point.frameMs, point.flip) + ": measured";
    std::string angles;
    for (const FairPoint::Angle& angle : point.angles) {
      text += formatted("\n  FLIP %.4f at %g°, ", angle.flip, angle.angleDeg) + durationText(angle.frameMs);
      angles += (angles.empty() ? "" : " ") + formatted("%g", angle.angleDeg, 0.0);
    }
    add("measured", point.configuration, point.frameMs, point.flip, text, angles, point.pictureSize);
  }
  if (!fair.points().empty()) shown.front = fair.front();
  const size_t measured = shown.points.size();
  for (const LiveFront::Point& point : live.points()) {
    std::string angles;
    for (const LiveFront::Bucket& bucket : point.buckets) angles += (angles.empty() ? "" : " ") + formatted("%g", bucket.fromDeg, 0.0);
    add("seen", point.configuration, point.frameMs, point.flip, describe(point, live.rankedAnglesDeg()) + "\nSeen while somebody looked around, not measured.", angles, point.pictureSize);
    // Beside what was measured, what was only seen stands back.
    shown.points.back().isDim = point.standing != LiveFront::Standing::ranked || measured > 0;
    for (size_t i = 0; i < session.panelCount(); ++i)
      if (session.panel(i).configuration == point.configuration) shown.points.back().isMarked = true;
  }
  if (measured == 0) shown.front = live.front();
  if (sweep_) {
    const size_t first = shown.points.size();
    for (const Summary& summary : sweep_->summaries) {
      const std::string text = describe(summary.configuration) + "\n" + figures(summary.frameMs, summary.flip) + ", of the sweep";
      add(kOfSweep, summary.configuration, summary.frameMs, summary.flip, text, "", {});
      shown.points.back().isHollow = true;
    }
    for (const size_t i : sweep_->front) shown.front.push_back(first + i);
  }
  for (const size_t i : shown.front) shown.points[i].isOnFront = true;
  return shown;
}

void PlotView::drawHeader(const Look& look) {
  isUnfolded_ = !look.remembered->folded.contains(kHeading);
  ImGui::SetNextItemOpen(isUnfolded_);
  ImGui::PushStyleColor(ImGuiCol_Header, ImGui::GetStyleColorVec4(ImGuiCol_FrameBg));
  isUnfolded_ = ImGui::CollapsingHeader(kHeading, ImGuiTreeNodeFlags_AllowItemOverlap);
  look.remembered->setFolded(kHeading, !isUnfolded_);
  ImGui::PopStyleColor();
  // Over its name alone: it is long.
  if (ImGui::GetIO().MousePos.x < ImGui::GetItemRectMin().x + look.px(170.0f)) tooltip(std::string(kHelp), look);
  std::string note = !error_.empty() ? error_ : measuringError_;
  if (note.empty() && sweep_) note = "hollow: " + sweep_->name + (sweep_->scene.empty() ? "" : " of " + sweep_->scene);
  if (note.empty()) return;
  ImGui::PushFont(look.fonts.small);
  const ImVec2 from = ImGui::GetItemRectMin(), to = ImGui::GetItemRectMax();
  const float width = ImGui::CalcTextSize(note.c_str()).x;
  const float left = std::max(from.x + look.px(170.0f), to.x - width - look.px(120.0f));
  ImDrawList* list = ImGui::GetWindowDrawList();
  list->PushClipRect({left, from.y}, to, true);
  list->AddText({left, 0.5f * (from.y + to.y - ImGui::GetTextLineHeight())}, ImGui::GetColorU32(error_.empty() && measuringError_.empty() ? palette().dimText : palette().errorText), note.c_str());
  list->PopClipRect();
  ImGui::PopFont();
}

Plot PlotView::plot(const Session& session) const {
  const Shown shown = shownOf(session, 0);
  Plot plot;
  plot.x = {"ms a frame", true};
  plot.y = {"FLIP", true};
  for (size_t i = 0; i < shown.points.size(); ++i) {
    const WarpDescriptor& technique = *shown.configurations[i]->technique;
    const std::string name = std::string(technique.label) + ", " + std::string(meaningOf(shown.sources[i]));
    auto series = std::ranges::find(plot.series, name, &PlotSeries::name);
    if (series == plot.series.end()) {
      plot.series.push_back({.name = name, .rgb = techniqueRgb(technique), .points = {}});
      series = plot.series.end() - 1;
    }
    series->points.push_back({shown.points[i].x, shown.points[i].y, labelOf(*shown.configurations[i]), shown.points[i].isOnFront});
  }
  return plot;
}

std::string PlotView::csv(const Session& session) const {
  const Shown shown = shownOf(session, 0);
  std::string text = "source,technique,configuration,frameMs,flip,anglesDeg,width,height,isOnFront\n";
  for (size_t i = 0; i < shown.points.size(); ++i) {
    const Configuration& configuration = *shown.configurations[i];
    text += std::string(shown.sources[i]) + "," + std::string(configuration.technique->name) + "," + csvField(labelOf(configuration)) + "," +
            formatted("%.6g,%.6g,", shown.points[i].x, shown.points[i].y) + shown.angles[i] + "," + sizeField(shown.sizes[i].x) + "," + sizeField(shown.sizes[i].y) + "," + (shown.points[i].isOnFront ? "true" : "false") + "\n";
  }
  return text;
}

void PlotView::drawMeasuring(Session& session, const Look& look) {
  const FairMeasuring& fair = session.fair();
  const std::string text = fair.isMeasuring() ? "Cancel, " + std::to_string(fair.done()) + " of " + std::to_string(fair.steps()) : std::string("Measure now");
  ImGui::PushFont(look.fonts.small);
  const float width = ImGui::CalcTextSize(text.c_str()).x + 2.0f * ImGui::GetStyle().FramePadding.x;
  const ImVec2 after = ImGui::GetCursorScreenPos(), from = ImGui::GetItemRectMin(), to = ImGui::GetItemRectMax();
  ImGui::SetCursorScreenPos({to.x - width - look.px(4.0f), from.y + look.px(2.0f)});
  const bool isPressed = ImGui::SmallButton(text.c_str());
  tooltip("All techniques on show by the newest frame, each at the same six angles between frame and view, 0 to 45 degrees: decoding, building and drawing are timed, "
          "the error is that against the truth. Freeze (F) first, to measure the frame that you look at.",
          look);
  ImGui::PopFont();
  ImGui::SetCursorScreenPos(after);
  if (!isPressed) return;
  if (fair.isMeasuring())
    session.cancelMeasuring();
  else
    session.measureNow();
}

void PlotView::draw(Session& session, size_t panel, const Look& look) {
  measuringError_ = session.fair().error();
  drawHeader(look);
  drawMeasuring(session, look);
  const ImVec2 room = ImGui::GetContentRegionAvail();
  if (!isUnfolded_ || room.y < look.px(60.0f)) return;
  const Shown shown = shownOf(session, panel);
  const bool hasList = room.x >= look.px(kLeastForListPx);
  const float listWidth = hasList ? look.px(kListPx) : 0.0f;
  ScatterLook plot;
  plot.gl = look.gl;
  plot.xLabel = "ms a frame";
  plot.yLabel = "FLIP";
  if (session.scene() != nullptr)
    plot.emptyText = session.knobs().takesShortcuts ? "shortcuts are no points: freeze and turn, or switch them off"
                                                    : "points come when the view rests";
  plot.small = look.fonts.small;
  plot.scale = look.scale;
  if (!hasList) plot.legend = shown.legend();
  const float plotWidth = hasList ? room.x - listWidth - look.px(8.0f) : room.x;
  std::optional<size_t> chosen = drawScatterPlot("points", shown.points, {plotWidth, room.y}, plot).clicked;
  if (hasList) {
    ImGui::SameLine(0.0f, look.px(8.0f));
    ImGui::BeginChild("front", {listWidth, room.y}, false);
    ImGui::PushFont(look.fonts.small);
    constexpr std::string_view kOfAngles = "Degrees between a frame and the view that it is warped to: errors grow with them.";
    ImGui::TextColored(palette().dimText, "Nothing beats these (rings)%s:", comparedAt(session).c_str());
    tooltip(std::string(kOfAngles), look);
    if (shown.front.empty()) ImGui::TextColored(palette().faintText, "%s", shown.points.empty() ? "points come when the view rests" : "none were seen at one angle yet");
    for (const size_t i : shown.front) {
      const ScatterPoint& point = shown.points[i];
      ImGui::PushID(static_cast<int>(i));
      const ImVec2 at = ImGui::GetCursorScreenPos();
      const float line = ImGui::GetTextLineHeight(), radius = look.px(3.5f);
      const ImVec2 center{at.x + 2.0f * radius, at.y + 0.5f * line};
      if (point.isHollow)
        ImGui::GetWindowDrawList()->AddCircle(center, radius, point.color, 0, look.px(1.4f));
      else
        ImGui::GetWindowDrawList()->AddCircleFilled(center, radius, point.color);
      const std::string text = durationText(point.x) + "   " + formatted("%.4f", point.y, 0.0) + "   " + labelOf(*shown.configurations[i]) + othersOf(*shown.configurations[i]);
      ImGui::Indent(look.px(16.0f));
      if (ImGui::Selectable(fitting(text, ImGui::GetContentRegionAvail().x).c_str())) chosen = i;
      tooltip(point.label, look);
      ImGui::Unindent(look.px(16.0f));
      ImGui::PopID();
    }
    if (const std::string apart = viewApart(session, panel); !apart.empty() && !shown.front.empty()) {
      ImGui::TextColored(palette().faintText, "%s", apart.c_str());
      tooltip(std::string(kOfAngles), look);
    }
    if (!shown.points.empty()) {
      ImGui::TextColored(palette().faintText, "%s", sweep_ ? "white rim: on show; faint: not compared; hollow: the sweep's" : "white rim: on show; faint: not compared");
      tooltip(std::string(kHelp), look);
    }
    // Beside what was measured all that was only seen is not compared: its points are faint.
    const auto apart = std::ranges::count_if(session.liveFront().points(), [](const LiveFront::Point& point) { return point.standing != LiveFront::Standing::ranked; });
    if (apart > 0 && !shown.front.empty() && session.fair().points().empty()) {
      ImGui::TextColored(palette().faintText, "%s not compared", apart == 1 ? "1 faint point is" : (std::to_string(apart) + " faint points are").c_str());
      tooltip("Seen at other angles, or in pictures of another size, than those that are compared: point at one to see which. Measure now compares all that are on show.", look);
    }
    ImGui::PopFont();
    ImGui::EndChild();
  }
  if (chosen) {
    const auto says = shown.sources[*chosen] == kOfSweep ? Session::Says::whatSweepsGoThrough : Session::Says::all;
    session.choose(panel, Configuration(*shown.configurations[*chosen]), says);  // a copy: the session may move its points
  }
}

}  // namespace warpscope::ui
