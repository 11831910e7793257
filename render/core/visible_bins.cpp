// One walk over a table's bins, from the last to the first.
// See visible_bins.h.
#include "render/core/visible_bins.h"

#include <algorithm>

namespace warpscope {

std::vector<int32_t> nextVisibleBins(const TransferTable& table) {
  std::vector<int32_t> next(static_cast<size_t>(table.bins));
  int32_t code = 2 * table.bins;
  for (int32_t bin = table.bins; bin-- > 0;) {
    const auto i = static_cast<size_t>(bin);
    const float alpha = table.alphas[i];
    if (alpha > 0.0f) {
      code = 2 * bin;
    } else if (alpha < 0.0f) {
      const TransferRefinement& pieces = table.refinements[static_cast<size_t>(-alpha) - 1];
      const auto first = table.alphas.begin() + table.bins + pieces.first;
      const auto shown = std::count_if(first, first + pieces.count, [](float opacity) { return opacity > 0.0f; });
      if (shown > 0) code = 2 * bin + (shown < pieces.count ? 1 : 0);
    }
    next[i] = code;
  }
  return next;
}

}  // namespace warpscope
