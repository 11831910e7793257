// Colour encodings. Inside the program colours are linear and premultiplied; 8 bit means straight alpha and the sRGB curve, which is
// what a sample carries and a PNG holds. sRGB: IEC 61966-2-1. Compositing: Porter, Duff 1984.
#pragma once

#include <cmath>
#include <cstdint>
#include <type_traits>

#include "render/core/host_device.h"

namespace warpscope {

/// Four 8-bit channels, red in the lowest byte, straight alpha, colour through the sRGB curve, alpha linear.
using Rgba8 = uint32_t;

WARPSCOPE_HD inline float srgbFromLinear(float linear) {
  return linear <= 0.0031308f ? 12.92f * linear : 1.055f * std::pow(linear, 1.0f / 2.4f) - 0.055f;
}

WARPSCOPE_HD inline float linearFromSrgb(float encoded) {
  return encoded <= 0.04045f ? encoded / 12.92f : std::pow((encoded + 0.055f) / 1.055f, 2.4f);
}

/// Clamps to [0, 1] and rounds to 8 bits; NaN becomes 0.
WARPSCOPE_HD inline uint32_t quantizeUnorm8(float value) {
  return value > 0.0f ? static_cast<uint32_t>(glm::min(value, 1.0f) * 255.0f + 0.5f) : 0u;
}

/// 8 bits to linear premultiplied colour.
WARPSCOPE_HD inline glm::vec4 decodeRgba8(Rgba8 code) {
  const float alpha = static_cast<float>(code >> 24) / 255.0f;
  return {linearFromSrgb(static_cast<float>(code & 255) / 255.0f) * alpha,
          linearFromSrgb(static_cast<float>(code >> 8 & 255) / 255.0f) * alpha,
          linearFromSrgb(static_cast<float>(code >> 16 & 255) / 255.0f) * alpha, alpha};
}

/// `front` over `back`, both premultiplied.
WARPSCOPE_HD inline glm::vec4 over(const glm::vec4& front, const glm::vec4& back) {
  return front + (1.0f - front.a) * back;
}

/// Both ways by tables, for whole images; a copy of the tables works on a device. Decoding is decodeRgba8 bit for bit. Encoding rounds the
/// formula's value to the nearest code; where that lies within 1e-4 of a boundary between two codes either may come out.
class ColorTables {
 public:
  static const ColorTables& instance();

  WARPSCOPE_HD glm::vec4 decode(Rgba8 code) const {
    const float alpha = static_cast<float>(code >> 24) / 255.0f;
    return {linear_[code & 255] * alpha, linear_[code >> 8 & 255] * alpha, linear_[code >> 16 & 255] * alpha, alpha};
  }
  /// Linear premultiplied colour to 8 bits. Where alpha rounds to 0 the straight colour is still kept.
  WARPSCOPE_HD Rgba8 encode(const glm::vec4& premultiplied) const {
    if (!(premultiplied.a > 0.0f)) return 0;
    const float inverse = 1.0f / premultiplied.a;
    return encodeChannel(premultiplied.r * inverse) | encodeChannel(premultiplied.g * inverse) << 8 |
           encodeChannel(premultiplied.b * inverse) << 16 | quantizeUnorm8(premultiplied.a) << 24;
  }
  /// What a screen shows of `premultiplied` before an opaque background (linear RGB).
  WARPSCOPE_HD Rgba8 encodeOver(const glm::vec4& premultiplied, const glm::vec3& background) const {
    return encode(over(premultiplied, glm::vec4(background, 1.0f))) | 0xff000000u;
  }
  /// 8-bit sRGB code of a linear value in [0, 1]; clamps.
  WARPSCOPE_HD uint32_t encodeChannel(float linear) const {
    if (!(linear > 0.0f)) return 0;
    if (linear >= 1.0f) return 255;
    uint32_t code = firstGuess_[static_cast<uint32_t>(linear * static_cast<float>(kGuesses))];
    while (upperBound_[code] <= linear) ++code;
    return code;
  }

 private:
  friend struct ColorLanes;  // color_lanes.h
  static constexpr uint32_t kGuesses = 4096;

  ColorTables();
  uint8_t firstGuess_[kGuesses];  // code of the lower end of each 1/kGuesses of the linear range; not at the end: vectors read four bytes at a time
  float linear_[256];
  float upperBound_[256];         // linear value at which code i ends and i + 1 begins
};
static_assert(std::is_trivially_copyable_v<ColorTables>);

}  // namespace warpscope
