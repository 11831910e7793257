// Edit distance and the sentence made of it.
// See nearest_name.h.
#include "render/core/nearest_name.h"

#include <algorithm>
#include <numeric>
#include <vector>

namespace warpscope {

size_t editDistance(std::string_view a, std::string_view b) {
  std::vector<size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), size_t{0});
  for (size_t i = 0; i < a.size(); ++i) {
    size_t diagonal = row[0];
    row[0] = i + 1;
    for (size_t j = 0; j < b.size(); ++j) {
      const size_t replaced = diagonal + (a[i] == b[j] ? 0 : 1);
      diagonal = row[j + 1];
      row[j + 1] = std::min({replaced, row[j] + 1, diagonal + 1});
    }
  }
  return row.back();
}

std::string unknownName(std::string_view kind, std::string_view name, std::span<const std::string_view> known) {
  std::string text = "unknown " + std::string(kind) + " '" + std::string(name.substr(0, 80)) + "'";
  if (known.empty()) return text;
  const auto nearest = std::min_element(known.begin(), known.end(), [&](std::string_view a, std::string_view b) {
    return editDistance(name.substr(0, 80), a) < editDistance(name.substr(0, 80), b);
  });
  text += "; did you mean '" + std::string(*nearest) + "'? Known:";
  for (const std::string_view candidate : known) text += " " + std::string(candidate);
  return text;
}

}  // namespace warpscope
