// See formatted.h.
#include "render/base/formatted.h"

#include <cstdio>

namespace warpscope {

std::string formatted(const char* pattern, double value) {
  char text[128];
  std::snprintf(text, sizeof text, pattern, value);
  return text;
}

}  // namespace warpscope
