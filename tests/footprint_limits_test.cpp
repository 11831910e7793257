// Every pixel of every footprint that a warp may walk lies in the row that a division says.
// Mirrors render/warp/splats/footprint_limits.h.
#include "render/warp/splats/footprint_limits.h"

#include <gtest/gtest.h>

namespace warpscope {
namespace {

TEST(FootprintLimits, RowsAreThoseOfADivision) {
  for (uint32_t width = 1; width <= kPixelsOfWarp; ++width) {
    const float perWidth = 1.0f / static_cast<float>(width);
    uint32_t wrong = 0;
    for (uint32_t pixel = 0; pixel < kPixelsOfWarp; ++pixel) wrong += rowOfPixel(pixel, perWidth) != static_cast<int>(pixel / width);
    ASSERT_EQ(wrong, 0u) << width;
  }
}

}  // namespace
}  // namespace warpscope
