// Reading and writing iso-values.
// See mode_settings.h.
#include "render/effects/mode_settings.h"

#include <limits>

#include "render/base/error.h"
#include "render/base/range.h"
#include "render/effects/setting_text.h"

namespace warpscope {
namespace {

constexpr Range kValueRange{-std::numeric_limits<double>::max(), std::numeric_limits<double>::max()};
constexpr Range kOpacityRange{0.0, 1.0};

IsoValue parseIsoValue(std::string_view text, std::string_view name) {
  const std::string what = std::string(name) + ": " + quotedSetting(text);
  IsoValue value;
  value.opacity = takeShare(text, value.opacity, kOpacityRange, what + ": the opacity");
  const std::optional<double> number = parseNumber(text);
  if (!number || !(*number >= kValueRange.lowest && *number <= kValueRange.highest)) throw UsageError(what + ": a value must be a finite number");
  value.value = *number;
  return value;
}

}  // namespace

std::string textOf(const IsoValues& values) {
  return textOfList(values, [](const IsoValue& value) {
    return numberText(value.value) + (value.opacity != 1.0f ? "@" + numberText(value.opacity) : "");
  });
}

IsoValues parseIsoValues(std::string_view text, std::string_view name) {
  return parseList<IsoValues>(text, name, "values", [&](std::string_view word) { return parseIsoValue(word, name); });
}

}  // namespace warpscope
