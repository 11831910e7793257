// Lists as text.
// See setting_text.h.
#include "render/effects/setting_text.h"

#include <algorithm>

#include "render/base/printable.h"

namespace warpscope {
namespace {

constexpr std::string_view kBlanks = " \t\n\r;";
constexpr size_t kMostShown = 60;

}  // namespace

std::vector<std::string_view> settingWords(std::string_view text) {
  std::vector<std::string_view> words;
  while (true) {
    const size_t begin = text.find_first_not_of(kBlanks);
    if (begin == std::string_view::npos) break;
    text.remove_prefix(begin);
    const size_t end = std::min(text.find_first_of(kBlanks), text.size());
    words.push_back(text.substr(0, end));
    text.remove_prefix(end);
  }
  if (words.size() == 1 && words.front() == "none") words.clear();
  return words;
}

std::string textOfNumbers(std::span<const float> numbers) {
  std::string text;
  for (const float number : numbers) text += (text.empty() ? "" : ",") + numberText(number);
  return text;
}

void parseNumbers(std::string_view text, std::span<float> numbers, const Range& range, const std::string& what) {
  const auto count = static_cast<size_t>(std::ranges::count(text, ',')) + 1;
  if (count != numbers.size())
    throw UsageError(what + ": wants " + std::to_string(numbers.size()) + " numbers with commas between them, not " + std::to_string(count));
  for (float& number : numbers) {
    const size_t comma = std::min(text.find(','), text.size());
    number = static_cast<float>(requireNumber(text.substr(0, comma), range, what + ": each number"));
    requireRange(number, range, what + ": each number");
    text.remove_prefix(std::min(comma + 1, text.size()));
  }
}

float takeShare(std::string_view& text, float absent, const Range& range, const std::string& what) {
  const size_t at = text.find('@');
  if (at == std::string_view::npos) return absent;
  const auto share = static_cast<float>(requireNumber(text.substr(at + 1), range, what));
  requireRange(share, range, what);
  text = text.substr(0, at);
  return share;
}

std::string quotedSetting(std::string_view text) {
  return "'" + printable(text.substr(0, kMostShown)) + (text.size() > kMostShown ? "..." : "") + "'";
}

}  // namespace warpscope
