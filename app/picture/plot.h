// What a plot shows: points and lines over two axes, with a legend.
// Plain data; svg_plot.h and plot_picture.h draw it.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace warpscope {

struct PlotPoint {
  double x = 0.0;
  double y = 0.0;
  std::string title;         ///< shown when pointed at, where that is possible
  bool isEmphasized = false; ///< drawn with a ring
};

struct PlotSeries {
  std::string name;   ///< in the legend; empty: not there
  uint32_t rgb = 0;   ///< sRGB, 0xRRGGBB
  std::vector<PlotPoint> points;
  bool isLine = false;    ///< points joined in their order
  bool isDashed = false;
};

struct PlotAxis {
  std::string label;
  bool isLogarithmic = false;
};

/// Values that a logarithmic axis cannot show (0 and less) stand at its lower end; points that are no numbers are left out. A plot without points is an empty
/// frame. Points that would hide each other are one mark: it says how many they are, has all their colours, and lists them when pointed at.
struct Plot {
  PlotAxis x, y;
  std::vector<PlotSeries> series;
};

}  // namespace warpscope
