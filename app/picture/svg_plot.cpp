// Elements and their attributes.
// See svg_plot.h.
#include "app/picture/svg_plot.h"

#include <cmath>
#include <cstdio>
#include <numbers>

#include "app/picture/plot_axis.h"
#include "app/picture/plot_drawing.h"

namespace warpscope {
namespace {

constexpr double kEnlarged = 1.26;  // on a page, at most

std::string numbered(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2f", value);
  return text;
}

std::string placed(const char* x, const char* y, const glm::dvec2& at) { return std::string(x) + "=\"" + numbered(at.x) + "\" " + y + "=\"" + numbered(at.y) + "\""; }

std::string textAt(const glm::dvec2& at, PlotDrawing::Anchor anchor, const std::string& text, const std::string& more = "") {
  constexpr const char* kAnchors[] = {"start", "middle", "end"};
  return "<text " + placed("x", "y", at) + " text-anchor=\"" + kAnchors[static_cast<size_t>(anchor)] + "\"" + more + ">" + escaped(text) + "</text>\n";
}

std::string circle(const glm::dvec2& at, double radius, const std::string& more) {
  return "<circle " + placed("cx", "cy", at) + " r=\"" + numbered(radius) + "\" " + more + "/>";
}

std::string colorOf(uint32_t rgb) {
  char text[8];
  std::snprintf(text, sizeof text, "#%06x", rgb & 0xffffff);
  return text;
}

std::string filled(uint32_t rgb) { return "fill=\"" + colorOf(rgb) + "\""; }

std::string disc(const PlotDrawing::Mark& mark, double radius) {
  if (mark.colors.size() == 1) return circle(mark.at, radius, filled(mark.colors[0]));
  std::string sectors;
  const auto placeAt = [&](size_t i) {
    const double turn = 2.0 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(mark.colors.size());
    return numbered(mark.at.x + radius * std::sin(turn)) + " " + numbered(mark.at.y - radius * std::cos(turn));
  };
  for (size_t i = 0; i < mark.colors.size(); ++i)
    sectors += "<path " + filled(mark.colors[i]) + " d=\"M" + numbered(mark.at.x) + " " + numbered(mark.at.y) + "L" + placeAt(i) + "A" + numbered(radius) + " " +
               numbered(radius) + " 0 0 1 " + placeAt(i + 1) + "Z\"/>";
  return sectors;
}

std::string drawn(const PlotDrawing::Mark& mark) {
  std::string svg;
  if (mark.isEmphasized) svg += circle(mark.at, PlotDrawing::kRingRadius, "class=\"ring\"") + "\n";
  svg += "<g class=\"mark\"><title>" + escaped(mark.title) + "</title>" + disc(mark, PlotDrawing::radiusOf(mark));
  if (mark.count > 1)
    svg += textAt(mark.at + PlotDrawing::kCountOffset, PlotDrawing::Anchor::start, std::to_string(mark.count), " class=\"count\" font-size=\"" + tickText(PlotDrawing::kCountPx) + "\"");
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
  const PlotDrawing drawing = layOut(plot);
  std::string svg = "<svg class=\"plot\" style=\"max-width:" + tickText(std::round(kEnlarged * drawing.width)) + "px\" viewBox=\"0 0 " + tickText(drawing.width) + " " +
                    tickText(drawing.height) + "\" role=\"img\" aria-label=\"" + escaped(plot.y.label + " against " + plot.x.label) + "\">\n";
  for (const PlotDrawing::Line& line : drawing.lines)
    svg += std::string("<line class=\"") + (line.isAxis ? "axis" : "grid") + "\" " + placed("x1", "y1", line.from) + " " + placed("x2", "y2", line.to) + "/>\n";
  for (const PlotDrawing::Label& label : drawing.labels)
    svg += textAt(label.at, label.anchor, label.text, label.isUpright ? " transform=\"rotate(-90 " + numbered(label.at.x) + " " + numbered(label.at.y) + ")\"" : "");
  for (const PlotDrawing::Curve& curve : drawing.curves) {
    svg += "<polyline fill=\"none\" stroke=\"" + colorOf(curve.rgb) + "\" stroke-width=\"" + numbered(PlotDrawing::kCurvePx) + "\"" +
           (curve.isDashed ? " stroke-dasharray=\"5 4\"" : "") + " points=\"";
    for (const glm::dvec2& point : curve.points) svg += numbered(point.x) + "," + numbered(point.y) + " ";
    svg += "\"/>\n";
  }
  for (const PlotDrawing::LegendEntry& entry : drawing.legend)
    svg += circle(entry.at + PlotDrawing::kKeyOffset, PlotDrawing::kKeyRadius, filled(entry.rgb)) + "\n" + textAt(entry.at, PlotDrawing::Anchor::start, entry.name);
  for (const PlotDrawing::Mark& mark : drawing.marks) svg += drawn(mark);
  return svg + "</svg>\n";
}

}  // namespace warpscope
