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
  const size_t at = text.find('@');
  if (at != std::string_view::npos) {
    const std::string ofOpacity = what + ": the opacity";
    value.opacity = static_cast<float>(requireNumber(text.substr(at + 1), kOpacityRange, ofOpacity));
    requireRange(value.opacity, kOpacityRange, ofOpacity);
    text = text.substr(0, at);
  }
  const std::optional<double> number = parseNumber(text);
  if (!number || !(*number >= kValueRange.lowest && *number <= kValueRange.highest)) throw UsageError(what + ": a value must be a finite number");
  value.value = *number;
  return value;
}

}  // namespace

std::string textOf(const IsoValues& values) {
  std::string text;
  for (const IsoValue& value : values) {
    text += (text.empty() ? "" : " ") + numberText(value.value);
    if (value.opacity != 1.0f) text += "@" + numberText(value.opacity);
  }
  return text.empty() ? "none" : text;
}

IsoValues parseIsoValues(std::string_view text, std::string_view name) {
  IsoValues values;
  for (const std::string_view word : settingWords(text)) {
    if (values.size() == IsoValues::kMost) throw UsageError(std::string(name) + ": at most " + std::to_string(IsoValues::kMost) + " values are possible");
    values.add(parseIsoValue(word, name));
  }
  return values;
}

}  // namespace warpscope
