// The colour that stands for a technique in every plot, on light and on dark pages.
// By its place in the registry, so that a technique keeps it from sweep to sweep.
#pragma once

#include <cstdint>
#include <iterator>

#include "render/warp/warp.h"

namespace warpscope {

/// sRGB, 0xRRGGBB.
inline uint32_t techniqueRgb(const WarpDescriptor& technique) {
  constexpr uint32_t kColors[] = {0x7b8794, 0xb0892f, 0x9a6b4f, 0xd1495b, 0x2b7de0, 0x159a74, 0x6f8f1f, 0xc2571a, 0x4aa5b8, 0xb04a97, 0x8a4fc7, 0x5b6abf};
  return kColors[static_cast<size_t>(&technique - warpRegistry().data()) % std::size(kColors)];
}

}  // namespace warpscope
