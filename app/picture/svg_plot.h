// Plots as SVG: points and lines over two axes, with a legend; each point says what it is when pointed at.
// SVG 1.1 elements alone, coloured by the page's style sheet where they have no colour of their own.
#pragma once

#include <string>
#include <vector>

namespace warpscope {

struct PlotPoint {
  double x = 0.0;
  double y = 0.0;
  std::string title;         ///< shown when pointed at
  bool isEmphasized = false; ///< drawn with a ring
};

struct PlotSeries {
  std::string name;   ///< in the legend; empty: not there
  std::string color;  ///< CSS
  std::vector<PlotPoint> points;
  bool isLine = false;    ///< points joined in their order
  bool isDashed = false;
};

struct PlotAxis {
  std::string label;
  bool isLogarithmic = false;
};

struct Plot {
  PlotAxis x, y;
  std::vector<PlotSeries> series;
};

/// Values that a logarithmic axis cannot show (0 and less) stand at its lower end; points that are no numbers are left out. A plot without points is an empty
/// frame. Points that would hide each other are one mark: it says how many they are, has all their colours, and lists them when pointed at.
std::string svgOf(const Plot& plot);
/// The same as a file of its own, on white.
std::string svgFileOf(const Plot& plot);

/// "&lt;" for "<" and so on: text for HTML, SVG and their attributes.
std::string escaped(const std::string& text);

}  // namespace warpscope
