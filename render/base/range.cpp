// The sentence.
// See range.h.
#include "render/base/range.h"

#include <charconv>

#include "render/base/error.h"

namespace warpscope {
namespace {

template <class T>
std::string shortest(T value) {
  char text[32];  // the longest double takes 24
  return {text, std::to_chars(text, text + sizeof text, value).ptr};
}

}  // namespace

std::string numberText(double value) { return shortest(value); }
std::string numberText(float value) { return shortest(value); }

std::string rangeText(const Range& range) { return numberText(range.lowest) + " to " + numberText(range.highest); }

void refuseOutside(const std::string& value, const Range& range, std::string_view name) {
  throw UsageError(std::string(name) + " must be between " + numberText(range.lowest) + " and " + numberText(range.highest) + ", not " + value);
}

}  // namespace warpscope
