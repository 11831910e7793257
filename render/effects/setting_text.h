// Parts of settings that are lists, as text: words between blanks, numbers between commas.
// One small grammar for lights, planes and values, so that options, files and the wire read and refuse alike.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "render/base/range.h"

namespace warpscope {

/// The words of a list, without the blanks between them. "none" alone, and nothing at all, are the empty list.
std::vector<std::string_view> settingWords(std::string_view text);

/// "1,0.5,-2": reads back as the same.
std::string textOfNumbers(std::span<const float> numbers);

/// Fills `numbers`, exactly as many as the text has. Throws UsageError that begins with `what`; none may lie outside `range`.
void parseNumbers(std::string_view text, std::span<float> numbers, const Range& range, const std::string& what);

/// What was typed, cut where it is long, in quotation marks.
std::string quotedSetting(std::string_view text);

}  // namespace warpscope
