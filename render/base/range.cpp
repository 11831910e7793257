// The sentence.
// See range.h.
#include "render/base/range.h"

#include <charconv>

#include "render/base/error.h"

namespace warpscope {
namespace {

constexpr size_t kMostShown = 40;  // characters of what was typed

template <class T>
std::string shortest(T value) {
  char text[32];  // the longest double takes 24
  return {text, std::to_chars(text, text + sizeof text, value).ptr};
}

}  // namespace

std::string numberText(double value) { return shortest(value); }
std::string numberText(float value) { return shortest(value); }

std::optional<double> parseNumber(std::string_view text) {
  double number = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  return error == std::errc() && end == text.data() + text.size() ? std::optional(number) : std::nullopt;
}

double requireNumber(std::string_view text, const Range& range, std::string_view name) {
  if (const std::optional<double> number = parseNumber(text)) return *number;
  throw UsageError("'" + std::string(text.substr(0, kMostShown)) + "' is no number; " + std::string(name) + " must be " + rangeText(range));
}

std::string rangeText(const Range& range) { return numberText(range.lowest) + " to " + numberText(range.highest); }

void refuseOutside(const std::string& value, const Range& range, std::string_view name) {
  throw UsageError(std::string(name) + " must be between " + numberText(range.lowest) + " and " + numberText(range.highest) + ", not " + value);
}

}  // namespace warpscope
