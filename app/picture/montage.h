// Techniques by views in one labelled picture.
// The arrangement of figure 3 in Zellmann 2020: one column a view, one row a technique, the reference on top.
#pragma once

#include <string>
#include <vector>

#include "render/core/color.h"
#include "render/core/image.h"

namespace warpscope {

struct MontageCell {
  Image<Rgba8> picture;  ///< opaque
  std::string caption;   ///< beneath it; may be empty
};

struct MontageRow {
  std::string label;
  std::vector<MontageCell> cells;  ///< one for each column
};

struct Montage {
  std::string title;
  std::vector<std::string> columns;
  std::vector<MontageRow> rows;
};

/// Cells are shrunk to `cellWidth` pixels where they are wider; all pictures have one size.
Image<Rgba8> drawMontage(const Montage& montage, uint32_t cellWidth);

}  // namespace warpscope
