// Counting from the middle, where the cameras' axis is.
// See sparse_pixels.h.
#include "app/picture/sparse_pixels.h"

#include <algorithm>

namespace warpscope {
namespace {

/// How many of so many pixels in a row, `every` apart, lie about its middle. The middle of an odd number of pixels is one, that of an even number lies between two:
/// both must be the same. 0: none can.
uint32_t countIn(uint32_t length, uint32_t every) {
  const uint32_t most = (length - 1) / every + 1;
  return most % 2 == length % 2 ? most : most - 1;
}

}  // namespace

SparsePixels sparsePixels(const glm::uvec2& size, uint32_t most) {
  SparsePixels pixels;
  const auto isPossible = [&](uint32_t every) { return countIn(size.x, every) > 0 && countIn(size.y, every) > 0; };
  while (std::max(size.x, size.y) > pixels.every * most && isPossible(pixels.every + 2)) pixels.every += 2;
  for (int axis = 0; axis < 2; ++axis) {
    pixels.size[axis] = countIn(size[axis], pixels.every);
    pixels.first[axis] = (size[axis] - (pixels.size[axis] - 1) * pixels.every - 1) / 2;
  }
  return pixels;
}

Camera sparseCamera(const Camera& camera, const SparsePixels& pixels) {
  Camera sparse = camera;
  sparse.width = pixels.size.x;
  sparse.height = pixels.size.y;
  sparse.tanHalfFovY = camera.tanHalfFovY * static_cast<float>(pixels.every * pixels.size.y) / static_cast<float>(camera.height);
  return sparse;
}

WarpedImage sparseImage(const WarpedImage& image, const SparsePixels& pixels) {
  WarpedImage sparse;
  sparse.color.resize(pixels.size.x, pixels.size.y);
  sparse.samples.resize(pixels.size.x, pixels.size.y);
  for (uint32_t y = 0; y < pixels.size.y; ++y)
    for (uint32_t x = 0; x < pixels.size.x; ++x) {
      const glm::uvec2 at = pixels.place({x, y});
      sparse.color(x, y) = image.color(at.x, at.y);
      sparse.samples(x, y) = image.samples(at.x, at.y);
    }
  return sparse;
}

}  // namespace warpscope
