// Ranges of numbers that a user may set, and the sentence that refuses what lies outside.
// Compared in the number's own type, so that a float at a bound counts as inside.
#pragma once

#include <concepts>
#include <optional>
#include <string>
#include <string_view>

namespace warpscope {

/// Both ends belong to it.
struct Range {
  double lowest, highest;
};

/// The shortest decimal text that reads back as the same number.
std::string numberText(double value);
std::string numberText(float value);

/// The number that all of `text` is, as C writes it; nothing if it is none.
std::optional<double> parseNumber(std::string_view text);

/// The same; throws UsageError "'TEXT' is no number; NAME must be LOWEST to HIGHEST". Whether it lies in `range` is not looked at.
double requireNumber(std::string_view text, const Range& range, std::string_view name);

/// "LOWEST to HIGHEST".
std::string rangeText(const Range& range);

/// Throws UsageError "NAME must be between LOWEST and HIGHEST, not VALUE".
[[noreturn]] void refuseOutside(const std::string& value, const Range& range, std::string_view name);

/// Throws as refuseOutside unless `value` lies in `range`; NaN does not.
template <std::floating_point T>
void requireRange(T value, const Range& range, std::string_view name) {
  if (value >= static_cast<T>(range.lowest) && value <= static_cast<T>(range.highest)) return;
  refuseOutside(numberText(value), range, name);
}

}  // namespace warpscope
