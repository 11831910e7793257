// Points over two logarithmic axes, to be pointed at and clicked on. Knows nothing of what they stand for.
// Drawn with ImGui's draw lists; scales and ticks are app/picture/plot_axis.h's.
#pragma once

#include <imgui.h>

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "app/ui/texture.h"

namespace warpscope::ui {

struct ScatterPoint {
  double x = 0.0;  ///< values that a logarithmic axis cannot show (0 and less) stand at its lower end; those that are not finite are left out
  double y = 0.0;
  ImU32 color = 0;
  std::string label;       ///< shown while the pointer is near
  bool isHollow = false;
  bool isDim = false;      ///< drawn faintly, beneath the others
  bool isOnFront = false;  ///< gets a ring
  bool isMarked = false;   ///< gets a white rim
};

struct ScatterLook {
  struct Entry {
    std::string name;
    ImU32 color = 0;
    size_t point = 0;  ///< that it stands for where it is pointed at: an index
  };
  std::string xLabel, yLabel;
  std::string emptyText;    ///< where points would be
  std::vector<Entry> legend;  ///< beneath the points, from the upper right corner down
  ImFont* small = nullptr;  ///< of ticks and labels
  const WindowGl* gl = nullptr;
  float scale = 1.0f;       ///< ImGui units that a length of 1 at scale 1 takes
};

struct ScatterAnswer {
  std::optional<size_t> hovered;  ///< index of the point nearest to the pointer, within a few pixels; else that of the legend's entry
  std::optional<size_t> clicked;  ///< the same, in the frame in which the button goes down
};

/// Fills `size` (ImGui units) at the cursor.
ScatterAnswer drawScatterPlot(const char* id, std::span<const ScatterPoint> points, const ImVec2& size, const ScatterLook& look);

}  // namespace warpscope::ui
