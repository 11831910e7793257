// The golden pictures themselves: that what is wrong would be noticed. They are compared by `warpscope check assets/golden`, the test golden.pictures.
//
// To update: build/warpscope check assets/golden --update    then look at every changed picture before committing it.
// The frame is marched from the scene's first view and drawn turned by 15 degrees, over dark grey. What no sample covers is violet, so
// that a hole that turns into background shows, and the other way round. One picture for all platforms.
#include <gtest/gtest.h>

#include <filesystem>

#include "app/picture/picture.h"
#include "app/picture/picture_difference.h"
#include "app/scene/scene.h"
#include "render/warp/warp.h"

namespace warpscope {
namespace {

namespace fs = std::filesystem;

constexpr double kMostPixels = 0.001;  // that may differ: check.json

fs::path goldenPath(const std::string& scene, std::string_view technique) {
  return fs::path(WARPSCOPE_GOLDEN_FOLDER) / (scene + "-" + std::string(technique) + "-15.png");
}

std::vector<std::string> sceneNames() {
  std::vector<std::string> names;
  for (const BuiltinScene& scene : builtinScenes()) names.push_back(scene.name);
  return names;
}

Image<Rgba8> moved(const Image<Rgba8>& picture, uint32_t dx, uint32_t dy) {
  Image<Rgba8> result(picture.width(), picture.height());
  for (uint32_t y = 0; y < picture.height(); ++y)
    for (uint32_t x = 0; x < picture.width(); ++x)
      result(x, y) = picture((x + dx) % picture.width(), (y + dy) % picture.height());
  return result;
}

Image<Rgba8> flipped(const Image<Rgba8>& picture, bool sideways) {
  Image<Rgba8> result(picture.width(), picture.height());
  for (uint32_t y = 0; y < picture.height(); ++y)
    for (uint32_t x = 0; x < picture.width(); ++x)
      result(x, y) = sideways ? picture(picture.width() - 1 - x, y) : picture(x, picture.height() - 1 - y);
  return result;
}

TEST(GoldenComparison, WrongPicturesAreFarOutsideTheTolerance) {
  for (const std::string& scene : sceneNames())
    for (const WarpDescriptor& technique : warpRegistry()) {
      const fs::path path = goldenPath(scene, technique.name);
      SCOPED_TRACE(path);
      const Image<Rgba8> picture = readPng(path);
        EXPECT_TRUE(comparePictures(picture, picture).isTolerable(kMostPixels));
      const PictureDifference wrong[] = {
          comparePictures(flipped(picture, false), picture), comparePictures(flipped(picture, true), picture),
          comparePictures(moved(picture, 1, 0), picture), comparePictures(moved(picture, 0, 1), picture)};
      for (const PictureDifference& difference : wrong) EXPECT_GT(difference.fraction, 20 * kMostPixels);
      // Red and blue exchanged.
      Image<Rgba8> exchanged = picture;
      for (Rgba8& pixel : exchanged) pixel = (pixel & 0xff00ff00u) | (pixel & 255) << 16 | (pixel >> 16 & 255);
      EXPECT_FALSE(comparePictures(exchanged, picture).isTolerable(kMostPixels));
    }
  // Techniques are told apart: none passes for another, but for splats and sprites, whose picture is that of spheres by definition.
  const auto pictureOf = [](const WarpDescriptor& technique) { return technique.name == "splats" || technique.name == "sprites" ? "spheres" : technique.name; };
  for (const std::string& scene : sceneNames())
    for (const WarpDescriptor& a : warpRegistry())
      for (const WarpDescriptor& b : warpRegistry())
        EXPECT_EQ(comparePictures(readPng(goldenPath(scene, a.name)), readPng(goldenPath(scene, b.name))).isTolerable(kMostPixels),
                  pictureOf(a) == pictureOf(b))
            << scene << ": " << a.name << " and " << b.name;
}

}  // namespace
}  // namespace warpscope
