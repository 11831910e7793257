// Sampling the function.
// See textbook_table.h.
#include "render/core/textbook_table.h"

#include <algorithm>
#include <cmath>

namespace warpscope {

TransferTable bakeTextbookTable(const TransferFunction& function, const TransferDomain& domain, float step) {
  constexpr int kEntries = TransferTable::kBins;
  TransferTable table;
  table.step = step;
  table.bins = kEntries;
  const float width = domain.upper - domain.lower;
  if (width > 0.0f) {
    table.scale = static_cast<float>(kEntries) / width;
    table.offset = -domain.lower * table.scale;
  }
  for (int i = 0; i < kEntries; ++i) {
    const float share = static_cast<float>(i) / static_cast<float>(kEntries - 1);
    const glm::vec4 straight = function.at(static_cast<double>(domain.lower + share * width));
    const float unitAlpha = std::clamp(straight.a, 0.0f, 1.0f);
    const float alpha = 1.0f - std::pow(1.0f - unitAlpha, step);
    table.entries.emplace_back(glm::vec3(straight) * alpha, alpha);
    table.alphas.push_back(alpha);
    table.unitAlphas.push_back(unitAlpha);
  }
  table.countVisible();
  return table;
}

}  // namespace warpscope
