// Texts from outside (names of files, keys of headers, what a peer says) made harmless for a terminal, at the one place where they are printed.
// UTF-8: RFC 3629. Control characters: ECMA-48, whose C1 set is U+0080 to U+009F; directions of writing: Unicode Standard Annex 9.
#pragma once

#include <string>
#include <string_view>

namespace warpscope {

/// `text` as one line that no terminal obeys: line breaks and tabs become blanks; other control characters and bytes that are no UTF-8 are
/// written out, as \x1b or \x9b, and so are characters that turn the direction of writing or break lines, as \u202e. Other well-formed UTF-8 stays
/// as it is.
std::string printable(std::string_view text);

/// The same of a text of several lines: its line feeds stay.
std::string printableLines(std::string_view text);

/// The same of a JSON document: its line feeds stay, and all else is written as JSON does (\u009b), which means the same there.
std::string printableJson(std::string_view document);

}  // namespace warpscope
