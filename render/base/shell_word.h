// Texts as words of a command line that can be copied into a shell.
#pragma once

#include <string>
#include <string_view>

namespace warpscope {

/// `text` as one word for a POSIX shell (IEEE 1003.1, 2.2): as it is where no character means anything to it, else in single quotes.
std::string shellWord(std::string_view text);

}  // namespace warpscope
