// Axes, ticks, points.
// See plot_drawing.h.
#include "app/picture/plot_drawing.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "app/picture/plot_axis.h"

namespace warpscope {
namespace {

constexpr double kPlotWidth = 506, kHeight = 420, kLeft = 64, kTop = 14, kBottom = 46;
constexpr double kLeastLegend = 190, kLegendIndent = 28, kLegendLine = 17, kLetter = 6.6;  // of text of PlotDrawing::kTextPx, on average
constexpr double kHidden = 2.0;  // points that are nearer to each other cannot be told apart

bool isNumberless(const PlotPoint& point) { return std::isnan(point.x) || std::isnan(point.y); }

/// Adds a point to the mark that it would hide, if there is one.
void add(const PlotPoint& point, uint32_t rgb, const glm::dvec2& at, std::vector<PlotDrawing::Mark>& marks) {
  auto mark = std::ranges::find_if(marks, [&](const PlotDrawing::Mark& other) { return glm::distance(other.at, at) < kHidden; });
  if (mark == marks.end()) mark = marks.insert(marks.end(), {at, {}, "", 0, false});
  if (std::ranges::find(mark->colors, rgb) == mark->colors.end()) mark->colors.push_back(rgb);
  mark->title += (mark->title.empty() ? "" : "\n\n") + point.title;
  mark->isEmphasized |= point.isEmphasized;
  ++mark->count;
}

}  // namespace

PlotDrawing layOut(const Plot& plot) {
  using Anchor = PlotDrawing::Anchor;
  PlotDrawing drawing;
  const double right = kLeft + kPlotWidth, bottom = kHeight - kBottom;
  double legendWidth = kLeastLegend;
  for (const PlotSeries& series : plot.series) legendWidth = std::max(legendWidth, kLegendIndent + kLetter * static_cast<double>(series.name.size()));
  AxisScale x(plot.x.isLogarithmic, kLeft, right), y(plot.y.isLogarithmic, bottom, kTop);
  for (const PlotSeries& series : plot.series)
    for (const PlotPoint& point : series.points) {
      x.include(point.x);
      y.include(point.y);
    }
  x.settle();
  y.settle();

  const auto named = static_cast<double>(std::ranges::count_if(plot.series, [](const PlotSeries& series) { return !series.name.empty(); }));
  drawing.width = std::ceil(right + legendWidth);
  drawing.height = std::max(kHeight, kTop + kLegendLine * (named + 1.0));
  for (const double tick : x.ticks()) {
    drawing.lines.push_back({{x.place(tick), kTop}, {x.place(tick), bottom}});
    drawing.labels.push_back({{x.place(tick), bottom + 16}, Anchor::middle, tickText(tick)});
  }
  for (const double tick : y.ticks()) {
    drawing.lines.push_back({{kLeft, y.place(tick)}, {right, y.place(tick)}});
    drawing.labels.push_back({{kLeft - 6, y.place(tick) + 4}, Anchor::end, tickText(tick)});
  }
  drawing.lines.push_back({{kLeft, bottom}, {right, bottom}, true});
  drawing.lines.push_back({{kLeft, kTop}, {kLeft, bottom}, true});
  drawing.labels.push_back({{0.5 * (kLeft + right), kHeight - 8}, Anchor::middle, plot.x.label});
  drawing.labels.push_back({{14, 0.5 * (kTop + bottom)}, Anchor::middle, plot.y.label, true});

  double legend = kTop + 8;
  for (const PlotSeries& series : plot.series) {
    if (series.isLine && series.points.size() > 1) {
      drawing.curves.push_back({series.rgb, series.isDashed, {}});
      for (const PlotPoint& point : series.points)
        if (!isNumberless(point)) drawing.curves.back().points.emplace_back(x.place(point.x), y.place(point.y));
    }
    for (const PlotPoint& point : series.points)
      if (!isNumberless(point)) add(point, series.rgb, {x.place(point.x), y.place(point.y)}, drawing.marks);
    if (series.name.empty()) continue;
    drawing.legend.push_back({{right + kLegendIndent, legend}, series.name, series.rgb});
    legend += kLegendLine;
  }
  return drawing;
}

}  // namespace warpscope
