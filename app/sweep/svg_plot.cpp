// Axes, ticks, points.
// See svg_plot.h.
#include "app/sweep/svg_plot.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace warpscope {
namespace {

constexpr double kWidth = 760, kHeight = 420, kLeft = 64, kRight = 190, kTop = 14, kBottom = 46;

std::string numbered(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2f", value);
  return text;
}

/// "25", "0.05", "20 k": thousands and millions by their signs.
std::string tickText(double value) {
  const double magnitude = std::abs(value);
  const double unit = magnitude >= 1e6 ? 1e6 : magnitude >= 1e4 ? 1e3 : 1.0;
  char text[32];
  std::snprintf(text, sizeof text, "%.4g%s", value / unit + 0.0, unit == 1e6 ? " M" : unit == 1e3 ? " k" : "");
  return text;
}

/// One axis: from values to places, and where its ticks are.
class Scale {
 public:
  Scale(bool isLogarithmic, double from, double to) : isLogarithmic_(isLogarithmic), from_(from), to_(to) {}

  void include(double value) {
    if (!std::isfinite(value) || (isLogarithmic_ && value <= 0.0)) return;
    lowest_ = isEmpty_ ? value : std::min(lowest_, value);
    highest_ = isEmpty_ ? value : std::max(highest_, value);
    isEmpty_ = false;
  }

  /// Once all values are included.
  void settle() {
    if (isEmpty_) lowest_ = isLogarithmic_ ? 0.1 : 0.0, highest_ = 1.0;
    if (isLogarithmic_) {
      lowest_ /= 1.25;
      highest_ *= 1.25;
    } else {
      if (highest_ == lowest_) highest_ = lowest_ + 1.0;
      const double margin = 0.04 * (highest_ - lowest_);
      lowest_ -= margin;
      highest_ += margin;
    }
  }

  double place(double value) const {
    const double shown = isLogarithmic_ ? std::max(value, lowest_) : value;
    const double share = isLogarithmic_ ? std::log(shown / lowest_) / std::log(highest_ / lowest_) : (shown - lowest_) / (highest_ - lowest_);
    return from_ + std::clamp(share, 0.0, 1.0) * (to_ - from_);
  }

  std::vector<double> ticks() const {
    std::vector<double> ticks;
    if (isLogarithmic_) {
      for (double power = std::pow(10.0, std::floor(std::log10(lowest_))); power <= highest_; power *= 10.0)
        for (const double factor : {1.0, 2.0, 5.0})
          if (factor * power >= lowest_ && factor * power <= highest_) ticks.push_back(factor * power);
      return ticks;
    }
    const double rough = (highest_ - lowest_) / 6.0;
    const double power = std::pow(10.0, std::floor(std::log10(rough)));
    double step = 10.0 * power;
    for (const double factor : {1.0, 2.0, 2.5, 5.0})
      if (factor * power >= rough) {
        step = factor * power;
        break;
      }
    for (double i = std::ceil(lowest_ / step); i * step <= highest_; ++i) ticks.push_back(i * step + 0.0);  // never -0
    return ticks;
  }

 private:
  bool isLogarithmic_;
  double from_, to_;
  double lowest_ = 0.0, highest_ = 0.0;
  bool isEmpty_ = true;
};

std::string textAt(double x, double y, const char* anchor, const std::string& text, const std::string& more = "") {
  return "<text x=\"" + numbered(x) + "\" y=\"" + numbered(y) + "\" text-anchor=\"" + anchor + "\"" + more + ">" + escaped(text) + "</text>\n";
}

std::string lineFromTo(double x1, double y1, double x2, double y2, const char* kind) {
  return "<line class=\"" + std::string(kind) + "\" x1=\"" + numbered(x1) + "\" y1=\"" + numbered(y1) + "\" x2=\"" + numbered(x2) + "\" y2=\"" +
         numbered(y2) + "\"/>\n";
}

}  // namespace

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
  const double right = kWidth - kRight, bottom = kHeight - kBottom;
  Scale x(plot.x.isLogarithmic, kLeft, right), y(plot.y.isLogarithmic, bottom, kTop);
  for (const PlotSeries& series : plot.series)
    for (const PlotPoint& point : series.points) {
      x.include(point.x);
      y.include(point.y);
    }
  x.settle();
  y.settle();

  std::string svg = "<svg class=\"plot\" viewBox=\"0 0 " + tickText(kWidth) + " " + tickText(kHeight) + "\" role=\"img\" aria-label=\"" +
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
  for (const PlotSeries& series : plot.series) {
    const std::string color = escaped(series.color);
    if (series.isLine && series.points.size() > 1) {
      svg += "<polyline fill=\"none\" stroke=\"" + color + "\" stroke-width=\"1.6\"" + (series.isDashed ? " stroke-dasharray=\"5 4\"" : "") + " points=\"";
      for (const PlotPoint& point : series.points) svg += numbered(x.place(point.x)) + "," + numbered(y.place(point.y)) + " ";
      svg += "\"/>\n";
    }
    for (const PlotPoint& point : series.points) {
      if (std::isnan(point.x) || std::isnan(point.y)) continue;
      const std::string at = "cx=\"" + numbered(x.place(point.x)) + "\" cy=\"" + numbered(y.place(point.y)) + "\"";
      if (point.isEmphasized) svg += "<circle class=\"ring\" " + at + " r=\"7.5\"/>\n";
      svg += "<circle " + at + " r=\"3.6\" fill=\"" + color + "\"><title>" + escaped(point.title) + "</title></circle>\n";
    }
    if (series.name.empty()) continue;
    svg += "<circle cx=\"" + numbered(right + 18) + "\" cy=\"" + numbered(legend - 4) + "\" r=\"4.5\" fill=\"" + color + "\"/>\n";
    svg += textAt(right + 28, legend, "start", series.name);
    legend += 17;
  }
  return svg + "</svg>\n";
}

}  // namespace warpscope
