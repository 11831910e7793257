// The sentence.
// See range.h.
#include "render/core/range.h"

#include <cstdio>
#include <string>

#include "render/core/error.h"

namespace warpscope {

void refuseOutside(double value, const Range& range, std::string_view name) {
  char text[96];
  std::snprintf(text, sizeof text, " must be between %g and %g, not %g", range.lowest, range.highest, value);
  throw UsageError(std::string(name) + text);
}

}  // namespace warpscope
