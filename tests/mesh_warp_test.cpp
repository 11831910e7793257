// The depth image as a surface: what it joins, what it cuts, and what it shows in the server's own view.
// Mirrors render/warp/mesh_warp.h.
#include <gtest/gtest.h>

#include "marcher_cases.h"
#include "render/march/own_picture.h"
#include "render/metrics/psnr.h"
#include "render/warp/mesh_warp.h"
#include "warp_cases.h"

namespace warpscope {
namespace {

WarpSettings cutAt(double share) {
  WarpSettings settings;
  settings.knobs.set(kMeshCutKnob, share);
  return settings;
}

class MeshOnPlatform : public OnPlatform {};
INSTANTIATE_TEST_SUITE_P(Gl, MeshOnPlatform, bothPlatforms(), platformName);

TEST_P(MeshOnPlatform, TheServersOwnViewIsTheFrames) {
  const Stage stage(smallScene("shells", 48), GetParam());
  const Camera camera = stage.camera(150, 110);
  const SampleFramePtr frame = stage.frame(camera, stage.scene().march);
  const Image<uint32_t> own = ownPicture(*frame);
  Image<glm::vec4> colors;
  resolveRayColors(*frame, own, colors);
  for (const double cut : {1e-3, 0.1, 100.0}) {
    const WarpedImage image = stage.draw("mesh", frame, camera, cutAt(cut));
    for (size_t i = 0; i < own.size(); ++i) ASSERT_EQ(image.samples[i] == kNoSample, own[i] == kNoSample) << i;
    EXPECT_GT(psnrSrgb(image.color, colors, glm::vec3(0.0f)), 55.0) << cut;
  }
}

/// Two walls one behind the other, the nearer one in front of the farther one's left half.
TEST_P(MeshOnPlatform, NeighboursAreJoinedUnlessTheyAreFurtherApartThanTheCut) {
  const Stage stage = syntheticStage(GetParam());
  std::vector<Sphere> spheres;
  constexpr int kSide = 20;
  for (int y = 0; y < kSide; ++y)
    for (int x = 0; x < kSide; ++x) {
      // Each on the ray of its own pixel, from z = 64 as the frame is.
      const float z = x < kSide / 2 ? 8.0f : 0.0f, scale = (64.0f - z) / 64.0f;
      spheres.push_back({{scale * 0.25f * (static_cast<float>(x - kSide / 2) + 0.0f), scale * 0.25f * (static_cast<float>(y - kSide / 2)), z}, 0.25f});
    }
  const SampleFramePtr frame = makeFrame(spheres);
  // From the right: between the walls there is a gap.
  const Camera camera = lookingFrom({12.0f, 0.0f, 64.0f}, {0.0f, 0.0f, 4.0f}, 240, 240, 0.06f);
  const auto covered = [&](double cut) { return coveredPixels(stage.draw("mesh", frame, camera, cutAt(cut))); };
  const size_t cutOpen = covered(0.1), joined = covered(0.2);  // the walls are 8 apart, the nearer one 56 away: a seventh
  EXPECT_GT(cutOpen, 5000u);
  EXPECT_GT(joined, cutOpen + 500u);
  EXPECT_EQ(covered(100.0), joined);
  EXPECT_EQ(covered(0.01), cutOpen);
}

TEST_P(MeshOnPlatform, ColoursGoStraightBetweenVertices) {
  const Stage stage = syntheticStage(GetParam());
  auto frame = std::make_shared<SampleFrame>(*makeFrame({{{-0.25f, -0.25f, 0.0f}, 0.25f}, {{0.0f, -0.25f, 0.0f}, 0.25f}, {{-0.25f, 0.0f, 0.0f}, 0.25f}, {{0.0f, 0.0f, 0.0f}, 0.25f}}));
  const float x0 = sphereOf(*frame, 0).center.x, x1 = sphereOf(*frame, 1).center.x;
  frame->colors[0] = frame->colors[2] = 0xff000000u;
  frame->colors[1] = frame->colors[3] = 0xffffffffu;
  Camera camera = frontCamera(200, 200, 64.0f);
  camera.tanHalfFovY = 0.006f;
  const WarpedImage image = stage.draw("mesh", frame, camera);
  const double edge = 2.0 * 64.0 * static_cast<double>(camera.tanHalfFovY) / camera.height;
  size_t seen = 0;
  for (uint32_t y = 0; y < 200; ++y)
    for (uint32_t x = 0; x < 200; ++x) {
      if (image.samples(x, y) == kNoSample) continue;
      ++seen;
      const double place = ((x + 0.5 - 100.0) * edge - static_cast<double>(x0)) / static_cast<double>(x1 - x0);
      ASSERT_NEAR(image.color(x, y).r, std::clamp(place, 0.0, 1.0), 0.02) << x << ", " << y;
      ASSERT_NEAR(image.color(x, y).a, 1.0f, 1e-5f);
    }
  EXPECT_GT(seen, 2000u);
}

}  // namespace
}  // namespace warpscope
