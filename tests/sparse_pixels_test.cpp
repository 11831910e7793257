// Every n-th pixel: cameras of fewer pixels have their rays, whatever the picture's size.
// Mirrors app/picture/sparse_pixels.h.
#include "app/picture/sparse_pixels.h"

#include <gtest/gtest.h>

#include "render/core/pixel_grid.h"

namespace warpscope {
namespace {

TEST(SparsePixels, HaveTheRaysOfThePixelsThatTheyAre) {
  for (const glm::uvec2& size : {glm::uvec2(474, 378), {473, 378}, {1024, 1024}, {1, 1}, {2, 2}, {97, 3}, {640, 2}, {3840, 2160}, {95, 96}, {96, 97}, {193, 1}}) {
    const SparsePixels pixels = sparsePixels(size, 96);
    ASSERT_GT(pixels.size.x, 0u);
    ASSERT_GT(pixels.size.y, 0u);
    const glm::uvec2 last = pixels.place(pixels.size - 1u);
    ASSERT_LT(last.x, size.x);
    ASSERT_LT(last.y, size.y);
    EXPECT_EQ(pixels.every % 2, 1u);
    if (std::min(size.x, size.y) > 90) EXPECT_LE(std::max(pixels.size.x, pixels.size.y), 97u) << size.x << "x" << size.y;
    if (std::min(size.x, size.y) > 90) EXPECT_GE(pixels.size.x * pixels.every + 2 * pixels.every, size.x) << "most of the picture";
    Camera camera;
    camera.eye = {3.0f, 5.0f, 50.0f};
    camera.width = size.x;
    camera.height = size.y;
    const Camera few = sparseCamera(camera, pixels);
    for (const glm::uvec2& at : {glm::uvec2(0), pixels.size - 1u, pixels.size / 2u}) {
      const glm::uvec2 whole = pixels.place(at);
      const glm::vec3 wanted = makePixelGrid(camera, 1.0f).ray(whole.x, whole.y).ray.direction, found = makePixelGrid(few, 1.0f).ray(at.x, at.y).ray.direction;
      EXPECT_LT(glm::distance(wanted, found), 2e-6f) << size.x << "x" << size.y << " at " << at.x << ", " << at.y;
    }
    WarpedImage image;
    image.color.resize(size.x, size.y);
    image.samples.resize(size.x, size.y);
    for (size_t i = 0; i < image.samples.size(); ++i) image.samples[i] = static_cast<uint32_t>(i);
    EXPECT_EQ(sparseImage(image, pixels).samples(pixels.size.x - 1, 0), last.x + pixels.first.y * size.x);
  }
}

}  // namespace
}  // namespace warpscope
