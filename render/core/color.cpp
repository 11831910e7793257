// Tables for the sRGB curve.
// See color.h.
#include "render/core/color.h"

#include <limits>

namespace warpscope {

const ColorTables& ColorTables::instance() {
  static const ColorTables tables;
  return tables;
}

ColorTables::ColorTables() {
  for (int code = 0; code < 256; ++code) {
    linear_[code] = linearFromSrgb(static_cast<float>(code) / 255.0f);
    upperBound_[code] = code == 255 ? std::numeric_limits<float>::infinity()
                                    : linearFromSrgb((static_cast<float>(code) + 0.5f) / 255.0f);
  }
  uint8_t code = 0;
  for (size_t i = 0; i < kGuesses; ++i) {
    while (upperBound_[code] <= static_cast<float>(i) / kGuesses) ++code;
    firstGuess_[i] = code;
  }
}

}  // namespace warpscope
