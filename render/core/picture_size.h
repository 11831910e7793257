// How large pictures may be: one rule for cameras, options, files and what comes over a network.
// The side is what samples have bits for (sample.h); the whole is what memory has to hold several times over.
#pragma once

#include <cstdint>
#include <string>

#include "render/core/image.h"

namespace warpscope {

/// Of one picture: 8192 squared, 1 GiB of colours at full precision. A side may be longer (kMaxImageSide) if the other is as much shorter.
inline constexpr uint64_t kMaxImagePixels = uint64_t{1} << 26;

constexpr bool isPictureSize(uint32_t width, uint32_t height) {
  return width >= 1 && height >= 1 && width <= kMaxImageSide && height <= kMaxImageSide && uint64_t{width} * height <= kMaxImagePixels;
}

/// "1 to 16384 pixels a side and at most 67108864 in all".
inline std::string pictureSizes() {
  return "1 to " + std::to_string(kMaxImageSide) + " pixels a side and at most " + std::to_string(kMaxImagePixels) + " in all";
}

}  // namespace warpscope
