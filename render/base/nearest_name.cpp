// Edit distance and the sentence made of it.
// See nearest_name.h.
#include "render/base/nearest_name.h"

#include <algorithm>
#include <numeric>
#include <vector>

namespace warpscope {
namespace {

constexpr size_t kLongestShown = 80;

}  // namespace

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

std::optional<std::string_view> nearestName(std::string_view name, std::span<const std::string_view> known) {
  const std::string_view word = name.substr(0, kLongestShown);
  std::optional<std::string_view> nearest;
  size_t least = 0;
  for (const std::string_view candidate : known) {
    // The beginning of a name is nearer to it than what differs in a letter.
    const bool isBeginning = word.size() >= 3 && candidate.starts_with(word);
    const size_t distance = isBeginning ? 1 : editDistance(word, candidate), longer = std::max(word.size(), candidate.size());
    if (distance >= longer || 2 * distance > longer + 1) continue;
    // Of two that are equally near the one with the same first letter: few mistype that.
    const size_t rank = 2 * distance + (word.substr(0, 1) == candidate.substr(0, 1) ? 0 : 1);
    if (nearest && rank >= least) continue;
    nearest = candidate;
    least = rank;
  }
  return nearest;
}

std::string knownInstead(std::string_view name, std::span<const std::string_view> known) {
  if (known.empty()) return "";
  const std::optional<std::string_view> nearest = nearestName(name, known);
  std::string text = nearest ? "; did you mean '" + std::string(*nearest) + "'? Known:" : "; known:";
  for (const std::string_view candidate : known) text += " " + std::string(candidate);
  return text;
}

std::string unknownName(std::string_view kind, std::string_view name, std::span<const std::string_view> known) {
  return "unknown " + std::string(kind) + " '" + std::string(name.substr(0, kLongestShown)) + "'" + knownInstead(name, known);
}

}  // namespace warpscope
