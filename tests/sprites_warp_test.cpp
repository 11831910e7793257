// Sprites against spheres: the same picture, from OpenGL.
// Mirrors render/warp/sprites_warp.h.
#include <gtest/gtest.h>

#include <cmath>

#include "warp_cases.h"

namespace warpscope {
namespace {

class SpritesOnPlatform : public OnPlatform {};
INSTANTIATE_TEST_SUITE_P(Gl, SpritesOnPlatform, bothPlatforms(), platformName);

/// Pixels that differ, of all: outlines and equal depths are decided by the last bit.
double differingShare(const WarpedImage& a, const WarpedImage& b) {
  size_t differing = 0;
  for (size_t i = 0; i < a.samples.size(); ++i) differing += a.samples[i] != b.samples[i];
  return static_cast<double>(differing) / static_cast<double>(a.samples.size());
}

TEST_P(SpritesOnPlatform, ShowWhatSpheresShow) {
  for (const char* name : {"block", "shells", "vessels"}) {
    const Stage stage(smallScene(name, 48), GetParam());
    for (const RadiusPolicy policy : {RadiusPolicy::voxel, RadiusPolicy::pixel}) {
      const SampleFramePtr frame = stage.frame(stage.camera(200, 150), withRadius(stage.scene(), policy));
      for (const double turn : {0.0, 12.0, 60.0, 180.0}) {
        const Camera camera = stage.camera(161, 143, turn);
        EXPECT_LE(differingShare(stage.draw("sprites", frame, camera), stage.draw("spheres", frame, camera)), 2e-4) << name << " " << turn;
      }
    }
  }
}

TEST_P(SpritesOnPlatform, SpheresThatAreLargerThanThePictureOrBesideItOrAroundTheEye) {
  const Stage stage = syntheticStage(GetParam());
  const std::vector<std::vector<Sphere>> clouds{
      {{{0.0f, 0.0f, 0.0f}, 8.0f}},                                   // fills the picture
      {{{7.9f, 0.0f, 4.0f}, 4.0f}, {{-9.0f, 6.0f, 3.0f}, 2.0f}},      // centres beside it
      {{{0.0f, 0.0f, 9.5f}, 2.0f}, {{3.0f, 1.0f, 9.9f}, 4.0f}},       // hold the eye, or nearly
      {{{0.0f, 0.0f, 12.0f}, 4.0f}, {{1.0f, 0.0f, 0.0f}, 0.0625f}}};  // behind it
  for (const std::vector<Sphere>& cloud : clouds) {
    const SampleFramePtr frame = makeFrame(cloud, 1.0f / 32.0f, 1023);
    for (const glm::uvec2& size : kOddSizes) {
      const Camera camera = frontCamera(size.x, size.y);
      EXPECT_LE(differingShare(stage.draw("sprites", frame, camera), stage.draw("spheres", frame, camera)), 5e-3) << size.x << "x" << size.y;
    }
  }
}

TEST_P(SpritesOnPlatform, SpheresWhoseSilhouetteIsOpenToTheSideOfAWideView) {
  const Stage stage = syntheticStage(GetParam());
  const SampleFramePtr frame = makeFrame({{{0.25f, 4.0f, 0.0f}, 2.0f}}, 1.0f / 32.0f, 1023);
  for (const double fovDeg : {130.0, 140.0, 170.0}) {
    Camera camera = frontCamera(256, 256, 0.125f);
    camera.tanHalfFovY = static_cast<float>(std::tan(0.5 * glm::radians(fovDeg)));
    const WarpedImage spheres = stage.draw("spheres", frame, camera);
    ASSERT_GT(coveredPixels(spheres), 1000u);
    EXPECT_LE(differingShare(stage.draw("sprites", frame, camera), spheres), 1e-3) << fovDeg;
  }
}

}  // namespace
}  // namespace warpscope
