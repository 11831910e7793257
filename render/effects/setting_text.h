// Parts of settings that are lists, as text: words between blanks, numbers between commas.
// One small grammar for lights, planes and values, so that options, files and the wire read and refuse alike.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "render/base/error.h"
#include "render/base/range.h"

namespace warpscope {

/// The words of a list, without the blanks between them. "none" alone, and nothing at all, are the empty list.
std::vector<std::string_view> settingWords(std::string_view text);

/// "1,0.5,-2": reads back as the same.
std::string textOfNumbers(std::span<const float> numbers);

/// Fills `numbers`, exactly as many as the text has. Throws UsageError that begins with `what`; none may lie outside `range`.
void parseNumbers(std::string_view text, std::span<float> numbers, const Range& range, const std::string& what);

/// Takes "@NUMBER" off the end of `text`; `absent` where there is none. Throws UsageError that begins with `what` unless it lies in `range`.
float takeShare(std::string_view& text, float absent, const Range& range, const std::string& what);

/// A `List` (ShortList) of what `parse` makes of each word of `text`. Throws UsageError, "NAME: at most 4 lights are possible", and what `parse` throws.
template <class List, class Parse>
List parseList(std::string_view text, std::string_view name, std::string_view plural, const Parse& parse) {
  List list;
  for (const std::string_view word : settingWords(text)) {
    if (list.size() == List::kMost) throw UsageError(std::string(name) + ": at most " + std::to_string(List::kMost) + " " + std::string(plural) + " are possible");
    list.add(parse(word));
  }
  return list;
}

/// Back: the elements' texts with blanks between them, "none" where there is no element.
template <class List, class TextOf>
std::string textOfList(const List& list, const TextOf& textOf) {
  std::string text;
  for (const auto& element : list) text += (text.empty() ? "" : " ") + textOf(element);
  return text.empty() ? "none" : text;
}

/// What was typed, cut where it is long, in quotation marks.
std::string quotedSetting(std::string_view text);

}  // namespace warpscope
