// Pixels that meet pieces against pieces' footprints, over random clouds and marched frames, near and far eyes, wide and narrow pixels and fields of view, and distances of all sizes.
// Mirrors render/warp/multihit/piece_footprint.h.
#include "render/warp/multihit/piece_footprint.h"

#include <gtest/gtest.h>

#include "render/warp/multihit/surface_hits.h"
#include "tests/dice.h"
#include "tests/frame_samples.h"
#include "tests/headless.h"
#include "tests/sphere_clouds.h"

namespace warpscope {
namespace {

struct Tally {
  size_t met = 0, pixels = 0, wholePixels = 0;
};

/// Every pixel of the picture is asked for every sample.
void expectAllMet(const SampleFrame& frame, const Camera& camera, Tally& tally) {
  ASSERT_TRUE(isOrthonormal(frame.camera));
  const SampleGrid grid = frame.grid();
  const FootprintView view = footprintViewOf(camera);
  const glm::vec3 origin = camera.eye - frame.camera.eye;
  for (size_t i = 0; i < frame.size(); ++i) {
    const Sphere sphere = sphereOf(frame, i);
    const PixelRect whole = sphereFootprint(view, sphere), rect = pieceFootprint(view, grid, frame.samples[i], origin, sphere, whole);
    const PixelFrustum frustum = frustumOf(grid.pixels, frame.samples[i], origin);
    for (int y = whole.y0; y < whole.y1; ++y)
      for (int x = whole.x0; x < whole.x1; ++x) {
        const bool isInside = x >= rect.x0 && x < rect.x1 && y >= rect.y0 && y < rect.y1;
        tally.pixels += isInside;
        ++tally.wholePixels;
        const Ray ray = pixelRay(camera, {static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f});
        const float t = intersectSphere(ray, sphere.center, sphere.radius);
        if (!(pieceDistance(frustum, ray.direction, sphere.center - ray.origin, t) < kNoHit)) continue;
        ++tally.met;
        ASSERT_TRUE(isInside) << "sample " << i << " in pixel " << x << ", " << y;
      }
  }
}

TEST(PieceFootprint, HoldsWhatRaysMeetOfMarchedFrames) {
  Tally tally;
  for (const char* name : {"block", "shells"}) {
    const Stage stage(smallScene(name, 64));
    const SampleFramePtr frame = stage.frame(stage.camera(480, 360), stage.scene().march);
    for (const double turn : {0.0, 1.0, 10.0, 45.0, 90.0, 179.0}) {
      SCOPED_TRACE(std::string(name) + ", " + std::to_string(turn));
      ASSERT_NO_FATAL_FAILURE(expectAllMet(*frame, stage.camera(483, 357, turn), tally));
    }
  }
  EXPECT_GT(tally.met, 50'000u);
  EXPECT_LT(tally.pixels, tally.wholePixels / 2);
}

TEST(PieceFootprint, HoldsWhatRaysMeetOfClouds) {
  Tally tally;
  for (const CloudShape shape : kCloudShapes)
    for (const float cell : {0.25f, 4.0f}) {
      // From outside, from among them, and from where the frame's own eye is.
      const SampleFrame frame = frameOfSpheres(makeCloud(shape, 300, 100.0f, 11), 16.0f, cell, static_cast<uint32_t>(252.0f / cell) | 1u, 512.0f);
      Camera own = frame.camera;
      own.width = own.height = 101;
      for (const Camera& camera : {own, orbitCamera(300.0f, 20.0f, 193, 161), orbitCamera(5.0f, 100.0f, 97, 101), orbitCamera(60.0f, 200.0f, 97, 101), orbitCamera(1e5f, 3.0f, 64, 64)}) {
        SCOPED_TRACE(::testing::Message() << "shape " << static_cast<int>(shape) << ", cell " << cell << ", eye " << camera.eye.z);
        ASSERT_NO_FATAL_FAILURE(expectAllMet(frame, camera, tally));
      }
    }
  EXPECT_GT(tally.met, 1000u);
}

/// Any turn of the camera about its own place.
Camera turned(Camera camera, Dice& dice) {
  camera.forward = dice.direction();
  camera.right = glm::normalize(glm::cross(camera.forward, dice.direction()));
  camera.up = glm::cross(camera.right, camera.forward);
  return camera;
}

/// Eyes within and beside what they look at, wide fields of view, lengths of all sizes.
TEST(PieceFootprint, HoldsWhatRaysMeetWhereverTheEyeIs) {
  Dice dice(71);
  Tally tally;
  for (int run = 0; run < 20'000; ++run) {
    const float scale = run % 4 == 0 ? dice.magnitude(-12.0f, 12.0f) : 1.0f;
    SampleFrame frame;
    frame.camera.width = frame.camera.height = 17;
    frame.camera.tanHalfFovY = dice.magnitude(-2.0f, 1.0f);
    frame.camera.eye = 10.0f * scale * dice.direction();
    frame.camera = turned(frame.camera, dice);
    frame.quantization = {{glm::vec3(-1e4f * scale), glm::vec3(1e4f * scale)}, scale, 0.0f, scale * 0x1p-12f};
    const float depth = scale * dice.uniform(0.1f, 30.0f), radius = scale * dice.uniform(0.01f, 1.9f);
    frame.samples.push_back(packSample(dice.below(17), dice.below(17), depth, radius, frame.quantization));
    frame.colors.resize(1);
    const Sphere sphere = sphereOf(frame, 0);
    Camera camera = frame.camera;
    camera.width = 8 + dice.below(60);
    camera.height = 8 + dice.below(40);
    camera.tanHalfFovY = dice.magnitude(-1.0f, 1.3f);
    // Along the sample's ray, beside it, or anywhere.
    const glm::vec3 along = glm::normalize(sphere.center - frame.camera.eye);
    camera.eye = sphere.center + sphere.radius * (dice.uniform(-1.5f, 1.5f) * along + dice.magnitude(-3.0f, 1.0f) * dice.direction());
    camera = turned(camera, dice);
    if (!isUsable(camera) || !isOrthonormal(frame.camera)) continue;
    SCOPED_TRACE(run);
    ASSERT_NO_FATAL_FAILURE(expectAllMet(frame, camera, tally));
  }
  EXPECT_GT(tally.met, 10'000u);
}

TEST(PieceFootprint, IsTheWholeForSamplesBesideTheirRays) {
  const SampleFrame frame = frameOfSpheres(makeCloud(CloudShape::random, 10, 100.0f, 5), 16.0f, 4.0f, 63, 512.0f);
  const Camera camera = orbitCamera(300.0f, 70.0f, 193, 161);
  const FootprintView view = footprintViewOf(camera);
  for (size_t i = 0; i < frame.size(); ++i) {
    Sphere sphere = sphereOf(frame, i);
    sphere.center.x += 3.0f;
    const PixelRect whole = sphereFootprint(view, sphere);
    EXPECT_EQ(pieceFootprint(view, frame.grid(), frame.samples[i], camera.eye - frame.camera.eye, sphere, whole), whole);
  }
}

TEST(PieceFootprint, OnlyBasesThatAreOneAreOrthonormal) {
  Camera camera = orbitCamera(300.0f, 70.0f, 193, 161);
  EXPECT_TRUE(isOrthonormal(camera));
  for (glm::vec3 Camera::* axis : {&Camera::right, &Camera::up, &Camera::forward}) {
    Camera off = camera;
    (off.*axis).y += 1e-4f;
    EXPECT_FALSE(isOrthonormal(off));
    (off.*axis).x = std::nanf("");
    EXPECT_FALSE(isOrthonormal(off));
  }
}

}  // namespace
}  // namespace warpscope
