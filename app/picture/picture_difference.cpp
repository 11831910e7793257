// Loops over pixels.
// See picture_difference.h.
#include "app/picture/picture_difference.h"

#include <algorithm>
#include <cstdlib>

namespace warpscope {
namespace {

int channelDifference(Rgba8 a, Rgba8 b) {
  int largest = 0;
  for (int shift = 0; shift < 32; shift += 8) largest = std::max(largest, std::abs(static_cast<int>(a >> shift & 255) - static_cast<int>(b >> shift & 255)));
  return largest;
}

}  // namespace

PictureDifference comparePictures(const Image<Rgba8>& image, const Image<Rgba8>& expected) {
  PictureDifference difference;
  difference.sameSize = image.width() == expected.width() && image.height() == expected.height() && !image.empty();
  if (!difference.sameSize) return difference;
  size_t different = 0;
  difference.largest = 0;
  for (size_t i = 0; i < image.size(); ++i) {
    const int largest = channelDifference(image[i], expected[i]);
    difference.largest = std::max(difference.largest, largest);
    different += largest > kChannelTolerance;
  }
  difference.fraction = static_cast<double>(different) / static_cast<double>(image.size());
  return difference;
}

Image<Rgba8> amplifiedDifference(const Image<Rgba8>& image, const Image<Rgba8>& expected) {
  Image<Rgba8> result(std::min(image.width(), expected.width()), std::min(image.height(), expected.height()));
  for (uint32_t y = 0; y < result.height(); ++y)
    for (uint32_t x = 0; x < result.width(); ++x) {
      Rgba8 pixel = 0xff000000u;
      for (int shift = 0; shift < 24; shift += 8) {
        const int a = static_cast<int>(image(x, y) >> shift & 255), b = static_cast<int>(expected(x, y) >> shift & 255);
        pixel |= static_cast<Rgba8>(std::min(255, 16 * std::abs(a - b))) << shift;
      }
      result(x, y) = pixel;
    }
  return result;
}

}  // namespace warpscope
