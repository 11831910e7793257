// A plot laid out: what stands where, whatever it is drawn with.
// Places in the plot's own units, y downwards: those of an SVG's view box, pixels of a picture at scale 1.
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/vec2.hpp>
#include <string>
#include <vector>

#include "app/picture/plot.h"

namespace warpscope {

struct PlotDrawing {
  enum class Anchor { start, middle, end };

  struct Line {
    glm::dvec2 from{}, to{};
    bool isAxis = false; ///< else of the grid
  };
  struct Label {
    glm::dvec2 at{};     ///< where its base line begins, or its middle or its end is
    Anchor anchor = Anchor::start;
    std::string text;
    bool isUpright = false; ///< reads from below to above
  };
  struct Curve {
    uint32_t rgb = 0;
    bool isDashed = false;
    std::vector<glm::dvec2> points;
  };
  /// Points that stand at one place, in the order in which they came: a disc in as many equal sectors as there are colours, the first one's from the top.
  struct Mark {
    glm::dvec2 at{};
    std::vector<uint32_t> colors;  ///< each once
    std::string title;
    size_t count = 0;
    bool isEmphasized = false;
  };
  struct LegendEntry {
    glm::dvec2 at{};  ///< where the name's base line begins
    std::string name;
    uint32_t rgb = 0;
  };

  static constexpr double kTextPx = 12.0, kCountPx = 9.0, kCurvePx = 1.6, kRingPx = 1.4, kRingRadius = 7.5, kKeyRadius = 4.5;
  /// Of a legend's disc and of the number beside a mark of several points, from where their names are and from its middle.
  static constexpr glm::dvec2 kKeyOffset{-10.0, -4.0}, kCountOffset{7.0, -5.0};

  double width = 0.0, height = 0.0;
  std::vector<Line> lines;
  std::vector<Label> labels;
  std::vector<Curve> curves;
  std::vector<LegendEntry> legend;
  std::vector<Mark> marks;  ///< over all else

  static double radiusOf(const Mark& mark) { return mark.count > 1 ? 4.8 : 3.6; }
};

PlotDrawing layOut(const Plot& plot);

}  // namespace warpscope
