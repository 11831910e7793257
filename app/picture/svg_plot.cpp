// Axes, ticks, points.
// See svg_plot.h.
#include "app/picture/svg_plot.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "app/picture/plot_axis.h"

namespace warpscope {
namespace {

constexpr double kPlotWidth = 506, kHeight = 420, kLeft = 64, kTop = 14, kBottom = 46;
constexpr double kEnlarged = 1.26, kLeastLegend = 190, kLegendIndent = 28, kLegendLine = 17, kLetter = 6.6;  // of 12 px type, on average
constexpr double kRadius = 3.6, kSharedRadius = 4.8;
constexpr double kHidden = 2.0;  // points that are nearer to each other cannot be told apart

std::string numbered(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2f", value);
  return text;
}

std::string textAt(double x, double y, const char* anchor, const std::string& text, const std::string& more = "") {
  return "<text x=\"" + numbered(x) + "\" y=\"" + numbered(y) + "\" text-anchor=\"" + anchor + "\"" + more + ">" + escaped(text) + "</text>\n";
}

std::string lineFromTo(double x1, double y1, double x2, double y2, const char* kind) {
  return "<line class=\"" + std::string(kind) + "\" x1=\"" + numbered(x1) + "\" y1=\"" + numbered(y1) + "\" x2=\"" + numbered(x2) + "\" y2=\"" +
         numbered(y2) + "\"/>\n";
}

/// Points that stand at one place, in the order in which they came.
struct Mark {
  double x = 0.0, y = 0.0;
  std::vector<std::string> colors;  ///< each once
  std::string title;
  size_t count = 0;
  bool isEmphasized = false;
};

/// Adds a point to the mark that it would hide, if there is one.
void add(const PlotPoint& point, const std::string& color, double x, double y, std::vector<Mark>& marks) {
  auto mark = std::find_if(marks.begin(), marks.end(), [&](const Mark& other) { return std::hypot(other.x - x, other.y - y) < kHidden; });
  if (mark == marks.end()) mark = marks.insert(marks.end(), {x, y, {}, "", 0, false});
  if (std::find(mark->colors.begin(), mark->colors.end(), color) == mark->colors.end()) mark->colors.push_back(color);
  mark->title += (mark->title.empty() ? "" : "\n\n") + point.title;
  mark->isEmphasized |= point.isEmphasized;
  ++mark->count;
}

/// A disc in as many equal sectors as there are colours, the first one's from the top.
std::string disc(const Mark& mark, double radius) {
  if (mark.colors.size() == 1)
    return "<circle cx=\"" + numbered(mark.x) + "\" cy=\"" + numbered(mark.y) + "\" r=\"" + numbered(radius) + "\" fill=\"" + escaped(mark.colors[0]) + "\"/>";
  std::string sectors;
  const auto placeAt = [&](size_t i) {
    const double turn = 2.0 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(mark.colors.size());
    return numbered(mark.x + radius * std::sin(turn)) + " " + numbered(mark.y - radius * std::cos(turn));
  };
  for (size_t i = 0; i < mark.colors.size(); ++i)
    sectors += "<path fill=\"" + escaped(mark.colors[i]) + "\" d=\"M" + numbered(mark.x) + " " + numbered(mark.y) + "L" + placeAt(i) + "A" + numbered(radius) + " " +
               numbered(radius) + " 0 0 1 " + placeAt(i + 1) + "Z\"/>";
  return sectors;
}

std::string drawn(const Mark& mark) {
  std::string svg;
  if (mark.isEmphasized) svg += "<circle class=\"ring\" cx=\"" + numbered(mark.x) + "\" cy=\"" + numbered(mark.y) + "\" r=\"7.5\"/>\n";
  svg += "<g class=\"mark\"><title>" + escaped(mark.title) + "</title>" + disc(mark, mark.count > 1 ? kSharedRadius : kRadius);
  if (mark.count > 1) svg += textAt(mark.x + 7.0, mark.y - 5.0, "start", std::to_string(mark.count), " class=\"count\" font-size=\"9\"");
  return svg + "</g>\n";
}

}  // namespace

std::string svgFileOf(const Plot& plot) {
  std::string svg = svgOf(plot);
  const size_t afterTag = svg.find('>') + 1;
  svg.insert(afterTag,
             "\n<style>text{fill:#222;font:12px sans-serif}.grid{stroke:#ddd}.axis{stroke:#777}.ring{fill:none;stroke:#222;stroke-width:1.4}</style>\n"
             "<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>");
  svg.insert(std::string("<svg").size(), " xmlns=\"http://www.w3.org/2000/svg\"");
  return svg;
}

std::string escaped(const std::string& text) {
  std::string result;
  for (const char c : text) {
    switch (c) {
      case '<': result += "&lt;"; break;
      case '>': result += "&gt;"; break;
      case '&': result += "&amp;"; break;
      case '"': result += "&quot;"; break;
      case '\'': result += "&#39;"; break;
      default: result += c;
    }
  }
  return result;
}

std::string svgOf(const Plot& plot) {
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

  const double width = std::ceil(right + legendWidth);
  const auto named = static_cast<double>(std::count_if(plot.series.begin(), plot.series.end(), [](const PlotSeries& series) { return !series.name.empty(); }));
  const double height = std::max(kHeight, kTop + kLegendLine * (named + 1.0));
  std::string svg = "<svg class=\"plot\" style=\"max-width:" + tickText(std::round(kEnlarged * width)) + "px\" viewBox=\"0 0 " + tickText(width) + " " +
                    tickText(height) + "\" role=\"img\" aria-label=\"" +
                    escaped(plot.y.label + " against " + plot.x.label) + "\">\n";
  for (const double tick : x.ticks()) {
    svg += lineFromTo(x.place(tick), kTop, x.place(tick), bottom, "grid");
    svg += textAt(x.place(tick), bottom + 16, "middle", tickText(tick));
  }
  for (const double tick : y.ticks()) {
    svg += lineFromTo(kLeft, y.place(tick), right, y.place(tick), "grid");
    svg += textAt(kLeft - 6, y.place(tick) + 4, "end", tickText(tick));
  }
  svg += lineFromTo(kLeft, bottom, right, bottom, "axis") + lineFromTo(kLeft, kTop, kLeft, bottom, "axis");
  svg += textAt(0.5 * (kLeft + right), kHeight - 8, "middle", plot.x.label);
  const double middle = 0.5 * (kTop + bottom);
  svg += textAt(14, middle, "middle", plot.y.label, " transform=\"rotate(-90 14 " + numbered(middle) + ")\"");

  double legend = kTop + 8;
  std::vector<Mark> marks;
  for (const PlotSeries& series : plot.series) {
    const std::string color = escaped(series.color);
    if (series.isLine && series.points.size() > 1) {
      svg += "<polyline fill=\"none\" stroke=\"" + color + "\" stroke-width=\"1.6\"" + (series.isDashed ? " stroke-dasharray=\"5 4\"" : "") + " points=\"";
      for (const PlotPoint& point : series.points) svg += numbered(x.place(point.x)) + "," + numbered(y.place(point.y)) + " ";
      svg += "\"/>\n";
    }
    for (const PlotPoint& point : series.points)
      if (!std::isnan(point.x) && !std::isnan(point.y)) add(point, series.color, x.place(point.x), y.place(point.y), marks);
    if (series.name.empty()) continue;
    svg += "<circle cx=\"" + numbered(right + 18) + "\" cy=\"" + numbered(legend - 4) + "\" r=\"4.5\" fill=\"" + color + "\"/>\n";
    svg += textAt(right + kLegendIndent, legend, "start", series.name);
    legend += kLegendLine;
  }
  for (const Mark& mark : marks) svg += drawn(mark);  // on all lines
  return svg + "</svg>\n";
}

}  // namespace warpscope
