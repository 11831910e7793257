// Decoding, and writing out what is not to be obeyed.
// See printable.h.
#include "render/base/printable.h"

#include <cstdint>
#include <cstdio>

namespace warpscope {
namespace {

struct Character {
  char32_t code;
  size_t bytes;  ///< 0: the text does not begin with well-formed UTF-8
};

Character firstOf(std::string_view text) {
  const auto at = [&](size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned char lead = at(0);
  if (lead < 0x80) return {lead, 1};
  const size_t bytes = lead >= 0xc2 && lead < 0xe0 ? 2 : lead >= 0xe0 && lead < 0xf0 ? 3 : lead >= 0xf0 && lead < 0xf5 ? 4 : 0;
  if (bytes == 0 || text.size() < bytes) return {lead, 0};
  char32_t code = lead & (0x7fu >> bytes);
  for (size_t i = 1; i < bytes; ++i) {
    if ((at(i) & 0xc0) != 0x80) return {lead, 0};
    code = code << 6 | (at(i) & 0x3fu);
  }
  // Longer than need be, half of a pair of UTF-16, or beyond Unicode: sections 3 and 10 of the RFC.
  const bool isWhole = bytes == 2 || (bytes == 3 && code >= 0x800 && (code < 0xd800 || code > 0xdfff)) ||
                       (bytes == 4 && code >= 0x10000 && code <= 0x10ffff);
  return isWhole ? Character{code, bytes} : Character{lead, 0};
}

bool isObeyed(char32_t code) {
  const bool isControl = code < 0x20 || (code >= 0x7f && code <= 0x9f);
  const bool breaksLines = code == 0x2028 || code == 0x2029;
  const bool turns = code == 0x61c || code == 0x200e || code == 0x200f || (code >= 0x202a && code <= 0x202e) || (code >= 0x2066 && code <= 0x2069);
  return isControl || breaksLines || turns;
}

enum class Form { line, lines, json };

std::string written(std::string_view text, Form form) {
  std::string result;
  result.reserve(text.size());
  while (!text.empty()) {
    const auto [code, bytes] = firstOf(text);
    char escape[12];
    if (bytes == 1 && code == '\n') {
      result += form == Form::line ? ' ' : '\n';
    } else if (bytes == 1 && (code == '\r' || code == '\t')) {
      result += ' ';
    } else if (bytes == 0 || isObeyed(code)) {
      std::snprintf(escape, sizeof escape, bytes < 2 && form != Form::json ? "\\x%02x" : "\\u%04x", static_cast<unsigned>(code));
      result += escape;
    } else {
      result += text.substr(0, bytes);
    }
    text.remove_prefix(bytes == 0 ? 1 : bytes);
  }
  return result;
}

}  // namespace

std::string printable(std::string_view text) { return written(text, Form::line); }

std::string printableLines(std::string_view text) { return written(text, Form::lines); }

std::string printableJson(std::string_view document) { return written(document, Form::json); }

}  // namespace warpscope
