// One number in a sentence or a table.
// std::snprintf into a string.
#pragma once

#include <string>

namespace warpscope {

/// "%.1f dB" and 3.14159: "3.1 dB". `pattern` takes one double; what it makes has at most 127 bytes.
std::string formatted(const char* pattern, double value);

}  // namespace warpscope
