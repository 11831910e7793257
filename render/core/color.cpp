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
  for (size_t i = 0; i < firstGuess_.size(); ++i) {
    while (upperBound_[code] <= static_cast<float>(i) / firstGuess_.size()) ++code;
    firstGuess_[i] = code;
  }
}

uint32_t ColorTables::encodeChannel(float linear) const {
  if (!(linear > 0.0f)) return 0;
  if (linear >= 1.0f) return 255;
  uint32_t code = firstGuess_[static_cast<size_t>(linear * firstGuess_.size())];
  while (upperBound_[code] <= linear) ++code;
  return code;
}

Rgba8 ColorTables::encode(const glm::vec4& premultiplied) const {
  if (!(premultiplied.a > 0.0f)) return 0;
  const float inverse = 1.0f / premultiplied.a;
  return encodeChannel(premultiplied.r * inverse) | encodeChannel(premultiplied.g * inverse) << 8 |
         encodeChannel(premultiplied.b * inverse) << 16 | quantizeUnorm8(premultiplied.a) << 24;
}

}  // namespace warpscope
