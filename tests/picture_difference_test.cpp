// Mirrors picture_difference.h.
#include "app/picture/picture_difference.h"

#include <gtest/gtest.h>

namespace warpscope {
namespace {

constexpr double kMost = 0.001;

TEST(PictureDifference, CountsPixelsBeyondTheTolerance) {
  const Image<Rgba8> black(100, 50, 0xff000000u);
  Image<Rgba8> other = black;
  for (uint32_t i = 0; i < 5; ++i) other[i] = 0xff030000u;  // 3/255 in one channel, 0.1 % of the pixels
  other[10] = 0xff020202u;                                  // within
  EXPECT_TRUE(comparePictures(other, black).isTolerable(kMost));
  EXPECT_DOUBLE_EQ(comparePictures(other, black).fraction, 0.001);
  EXPECT_EQ(comparePictures(other, black).largest, 3);
  other[20] = 0xfc000000u;  // alpha counts as well
  EXPECT_FALSE(comparePictures(other, black).isTolerable(kMost));
  EXPECT_FALSE(comparePictures(Image<Rgba8>(50, 100), black).isTolerable(kMost));
  EXPECT_FALSE(comparePictures({}, {}).isTolerable(kMost));
}

TEST(PictureDifferenceMap, IsSixteenfoldAndOpaque) {
  const Image<Rgba8> image(4, 3, 0x00000010u), expected(4, 3, 0xff000012u);
  const Image<Rgba8> map = amplifiedDifference(image, expected);
  EXPECT_EQ(map(0, 0), 0xff000020u);
  EXPECT_EQ(amplifiedDifference(expected, expected)(3, 2), 0xff000000u);
  EXPECT_EQ(amplifiedDifference(Image<Rgba8>(1, 1, 0xffffffffu), Image<Rgba8>(1, 1, 0xff000000u))(0, 0), 0xffffffffu);
}

}  // namespace
}  // namespace warpscope
