// Golden pictures: every technique on every built-in scene, through EGL and through OSMesa, against assets/golden/<scene>-<technique>.png.
// One picture for all platforms; the tolerance is explained in golden.h.
//
// To update: WARPSCOPE_UPDATE_GOLDEN=1 ctest --test-dir build -R Golden    then look at every changed picture before committing it.
// The frame is marched from the scene's first view and drawn turned by 15 degrees, over dark grey. What no sample covers is violet, so
// that a hole that turns into background shows, and the other way round.
#include "tests/golden.h"

#include <gtest/gtest.h>

#include "render/base/error.h"
#include "tests/headless.h"
#include "tests/test_folder.h"

namespace warpscope {
namespace {

namespace fs = std::filesystem;

constexpr uint32_t kSide = 192;
constexpr double kTurnDeg = 15.0;
constexpr glm::vec3 kBackground{0.03f};
constexpr PixelMarks kMarks{.uncovered = 0xff502030u};

fs::path goldenPath(const std::string& scene, std::string_view technique) {
  return fs::path(WARPSCOPE_GOLDEN_FOLDER) / (scene + "-" + std::string(technique) + ".png");
}

using GoldenCase = std::tuple<gl::Platform, std::string>;

std::string caseName(const testing::TestParamInfo<GoldenCase>& info) {
  std::string name = std::get<1>(info.param) + (std::get<0>(info.param) == gl::Platform::egl ? "Egl" : "Osmesa");
  name.erase(std::remove(name.begin(), name.end(), '-'), name.end());
  return name;
}

std::vector<std::string> sceneNames() {
  std::vector<std::string> names;
  for (const BuiltinScene& scene : builtinScenes()) names.push_back(scene.name);
  return names;
}

class Golden : public testing::TestWithParam<GoldenCase> {};
INSTANTIATE_TEST_SUITE_P(Scenes, Golden,
                         testing::Combine(testing::Values(gl::Platform::egl, gl::Platform::osmesa), testing::ValuesIn(sceneNames())),
                         caseName);

TEST_P(Golden, EveryTechnique) {
  const auto& [platform, sceneName] = GetParam();
  const Stage stage(openScene(sceneName), platform);
  const SampleFramePtr frame = stage.frame(stage.camera(kSide, kSide), stage.scene().march);
  const Camera camera = stage.camera(kSide, kSide, kTurnDeg);
  WarpSettings settings;
  settings.reference = stage.scene().march.render;
  for (const WarpDescriptor& technique : warpRegistry()) {
    const Image<Rgba8> picture = toScreen(stage.draw(technique.name, frame, camera, settings), kBackground, kMarks);
    const fs::path path = goldenPath(sceneName, technique.name);
    if (isUpdatingGolden()) {
      fs::create_directories(path.parent_path());
      if (!fs::exists(path) || readPng(path) != picture) writeFileWhole(path, encodePng(picture));
      continue;
    }
    if (!fs::exists(path)) {
      ADD_FAILURE() << "no golden picture " << path << "; golden_test.cpp says how to make it";
      continue;
    }
    const Image<Rgba8> expected = readPng(path);
    const PictureDifference difference = comparePictures(picture, expected);
    if (difference.isTolerable()) continue;
    const std::string name = caseName({GetParam(), 0}) + "-" + std::string(technique.name);
    ADD_FAILURE() << sceneName << ", " << technique.name << ": " << 100.0 * difference.fraction
                  << " % of the pixels differ, the largest difference is " << difference.largest << "/255"
                  << leaveArtifacts(name, picture, expected);
  }
  if (isUpdatingGolden()) GTEST_SKIP() << "golden pictures were written, not compared";
}

// --- The comparison itself can fail

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
      ASSERT_EQ(picture.width(), kSide);
      EXPECT_TRUE(comparePictures(picture, picture).isTolerable());
      const PictureDifference wrong[] = {
          comparePictures(flipped(picture, false), picture), comparePictures(flipped(picture, true), picture),
          comparePictures(moved(picture, 1, 0), picture), comparePictures(moved(picture, 0, 1), picture)};
      for (const PictureDifference& difference : wrong) EXPECT_GT(difference.fraction, 20 * kGoldenPixelTolerance);
      // Red and blue exchanged.
      Image<Rgba8> exchanged = picture;
      for (Rgba8& pixel : exchanged) pixel = (pixel & 0xff00ff00u) | (pixel & 255) << 16 | (pixel >> 16 & 255);
      EXPECT_FALSE(comparePictures(exchanged, picture).isTolerable());
    }
  // Techniques are told apart: none passes for another, but for splats and sprites, whose picture is that of spheres by definition.
  const auto pictureOf = [](const WarpDescriptor& technique) { return technique.name == "splats" || technique.name == "sprites" ? "spheres" : technique.name; };
  for (const std::string& scene : sceneNames())
    for (const WarpDescriptor& a : warpRegistry())
      for (const WarpDescriptor& b : warpRegistry())
        EXPECT_EQ(comparePictures(readPng(goldenPath(scene, a.name)), readPng(goldenPath(scene, b.name))).isTolerable(),
                  pictureOf(a) == pictureOf(b))
            << scene << ": " << a.name << " and " << b.name;
}

TEST(GoldenComparison, CountsPixelsBeyondTheTolerance) {
  const Image<Rgba8> black(100, 50, 0xff000000u);
  Image<Rgba8> other = black;
  for (uint32_t i = 0; i < 5; ++i) other[i] = 0xff030000u;  // 3/255 in one channel, 0.1 % of the pixels
  other[10] = 0xff020202u;                                  // within
  EXPECT_TRUE(comparePictures(other, black).isTolerable());
  EXPECT_DOUBLE_EQ(comparePictures(other, black).fraction, 0.001);
  EXPECT_EQ(comparePictures(other, black).largest, 3);
  other[20] = 0xfc000000u;  // alpha counts as well
  EXPECT_FALSE(comparePictures(other, black).isTolerable());
  EXPECT_FALSE(comparePictures(Image<Rgba8>(50, 100), black).isTolerable());
  EXPECT_FALSE(comparePictures({}, {}).isTolerable());
}

TEST(GoldenComparison, LeavesPicturesWhereTheEnvironmentSays) {
  const TestFolder folder;
  setenv("WARPSCOPE_TEST_ARTIFACTS", folder.file("deep/er").c_str(), 1);
  const Image<Rgba8> image(4, 3, 0xff000010u), expected(4, 3, 0xff000012u);
  const std::string text = leaveArtifacts("x", image, expected);
  EXPECT_EQ(folder.listing(), (std::vector<std::string>{"deep", "deep/er", "deep/er/x-difference.png", "deep/er/x-expected.png",
                                                        "deep/er/x.png"}));
  EXPECT_NE(text.find(folder.file("deep/er/x-difference.png")), std::string::npos);
  EXPECT_EQ(readPng(folder.file("deep/er/x.png")), image);
  EXPECT_EQ(readPng(folder.file("deep/er/x-difference.png"))(0, 0), 0xff000020u);
  unsetenv("WARPSCOPE_TEST_ARTIFACTS");
}

}  // namespace
}  // namespace warpscope
