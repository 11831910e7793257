// Pictures of techniques: cases 29, 50, 52 to 55 and 66. Truth: the frame's own pixels by the camera's conventions in
// double, marches. Mirrors render/warp/warp.h. On every platform of OpenGL: warp_test.cpp.
#include "render/warp/warp.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>
#include <set>

#include "render/core/ray_sphere.h"
#include "render/metrics/holes.h"
#include "render/warp/multihit_warp.h"
#include "render/warp/points_warp.h"
#include "render/warp/spheres_warp.h"
#include "tests/codec_frames.h"
#include "tests/frame_samples.h"
#include "tests/headless.h"
#include "tests/stability/backends.h"
#include "tests/stability/record.h"
#include "tests/test_volumes.h"
#include "tests/warp_cases.h"

namespace warpscope {
namespace {

/// What draws samples as spheres, one hit a ray, on either backend.
std::vector<std::pair<std::string, WarpSettings>> sphereTechniques() {
  std::vector<std::pair<std::string, WarpSettings>> all{{"spheres", {}}, {"splats", {}}, {"multihit", {}}};
  all.back().second.knobs.set(kHitsKnob, 1);
  return all;
}

Stage stageOn(Backend backend, const std::string& scene, uint32_t side = 48) {
  return Stage(smallScene(scene, side), gl::Platform::automatic, backend);
}

TEST_P(Case29, FramesOfNoneOneAndTwoSamples) {
  const Stage stage = stageOn(GetParam(), "block", 16);
  const Camera camera = frontCamera(65, 33);
  const std::vector<Sphere> spheres{{{0.0f, 0.0f, 0.0f}, 0.25f}, {{2.0f, 1.0f, 0.0f}, 0.25f}};
  for (const auto& [name, settings] : sphereTechniques())
    for (size_t count = 0; count <= 2; ++count) {
      const SampleFramePtr frame = makeFrame({spheres.begin(), spheres.begin() + static_cast<ptrdiff_t>(count)});
      const WarpedImage image = stage.draw(name, frame, camera, settings);
      std::set<uint32_t> seen(image.samples.begin(), image.samples.end());
      EXPECT_EQ(seen.erase(kNoSample), 1u);
      EXPECT_EQ(seen.size(), count) << name;
    }
  recordExact("techniques, frames of 0, 1, 2 samples", "definition", GetParam());
}

TEST_P(Case50, NothingAtOrBehindTheEyeIsSeen) {
  const Stage stage = stageOn(GetParam(), "block", 16);
  const Camera camera = frontCamera(64, 64);
  // At the eye; in its plane to all sides; behind it; behind it and far off the axis.
  const SampleFramePtr frame = makeFrame({{{0.0f, 0.0f, 10.0f}, 0.5f},
                                          {{1.0f, 0.0f, 10.0f}, 0.5f},
                                          {{0.0f, -1.0f, 10.0f}, 0.5f},
                                          {{0.0f, 0.0f, 12.0f}, 1.0f},
                                          {{0.5f, -0.5f, 30.0f}, 1.0f},
                                          {{100.0f, 0.0f, 11.0f}, 1.0f}},
                                         1.0f / 32.0f, 8191);
  for (const auto& [name, settings] : sphereTechniques())
    EXPECT_EQ(coveredPixels(stage.draw(name, frame, camera, settings)), 0u) << name;
  recordExact("techniques, samples at and behind the eye", "definition", GetParam());
}

TEST_P(Case52, SpheresThatFitTheirPixelShowEveryPixelItsOwnSample) {
  for (const BuiltinScene& builtin : builtinScenes()) {
    const Stage stage = stageOn(GetParam(), builtin.name);
    for (const glm::uvec2& size : kOddSizes) {
      SCOPED_TRACE(builtin.name + " " + std::to_string(size.x) + "x" + std::to_string(size.y));
      const Camera camera = stage.camera(size.x, size.y);
      const SampleFramePtr frame = stage.frame(camera, withRadius(stage.scene(), RadiusPolicy::pixel));
      for (const auto& [name, settings] : sphereTechniques())
        expectExactly(stage.draw(name, frame, camera, settings), ownPixels(*frame), *frame);
      WarpSettings embree;
      embree.knobs.set(kSphereTracingKnob, SphereTracing::embree);
      if (GetParam() == Backend::cpu)
        expectExactly(stage.draw("spheres", frame, camera, embree), ownPixels(*frame), *frame);
    }
  }
  recordExact("spheres, splats, multihit at the server's own camera", "the frame's own pixels", GetParam());
}

TEST_P(Case52, HoldIsExactInItsOwnView) {
  for (const BuiltinScene& builtin : builtinScenes()) {
    const Stage stage = stageOn(GetParam(), builtin.name);
    for (const glm::uvec2& size : kOddSizes) {
      SCOPED_TRACE(builtin.name + " " + std::to_string(size.x) + "x" + std::to_string(size.y));
      const Camera camera = stage.camera(size.x, size.y);
      const SampleFramePtr frame = stage.frame(camera, stage.scene().march);
      expectExactly(stage.draw("hold", frame, camera), ownPixels(*frame), *frame);
    }
  }
  recordExact("hold at the server's own camera", "the frame's own pixels", GetParam());
}

TEST(Case52, PointsShowEveryPixelItsOwnSample) {
  const Stage stage(smallScene("shells"));
  try {
    stage.resources().context();
  } catch (const std::exception& error) {
    GTEST_SKIP() << "no OpenGL here: " << error.what();
  }
  WarpSettings settings;
  settings.knobs.set(kPointSizeKnob, 1);
  for (const glm::uvec2& size : kOddSizes) {
    const Camera camera = stage.camera(size.x, size.y);
    const SampleFramePtr frame = stage.frame(camera, stage.scene().march);
    expectExactly(stage.draw("points", frame, camera, settings), ownPixels(*frame), *frame);
  }
  recordExact("points at the server's own camera", "the frame's own pixels");
}

TEST_P(Case53, OfEqualDepthsTheLowerIdIsSeenWhateverTheThreads) {
  const Stage stage = stageOn(GetParam(), "block", 16);
  const Camera camera = frontCamera(96, 80);
  std::vector<Sphere> spheres;
  for (int copy = 0; copy < 3; ++copy)
    for (int y = -12; y <= 12; ++y)
      for (int x = -12; x <= 12; ++x)
        spheres.push_back({{0.25f * static_cast<float>(x), 0.25f * static_cast<float>(y), 0.0f}, 0.25f});
  const SampleFramePtr frame = makeFrame(spheres);
  for (const auto& [name, settings] : sphereTechniques()) {
    WarpedImage first;
    for (const size_t threads : {1, 2, 5}) {
      SCOPED_TRACE(name + ", " + std::to_string(threads) + " threads");
      const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
      WarpedImage image = stage.draw(name, frame, camera, settings);
      ASSERT_GT(coveredPixels(image), 500u);
      for (const uint32_t id : image.samples) ASSERT_TRUE(id == kNoSample || id < 25 * 25) << id;
      if (threads == 1) first = image;
      EXPECT_EQ(image.samples, first.samples);
      EXPECT_EQ(image.color, first.color);
    }
  }
  recordExact("techniques, equal depths, 1, 2 and 5 threads", "the lower id", GetParam());
}

TEST_P(Case53, TheOrderOfSamplesDoesNotMatter) {
  const Stage stage = stageOn(GetParam(), "shells");
  const SampleFramePtr frame = stage.frame(stage.camera(160, 120), stage.scene().march);
  const Camera camera = stage.camera(150, 110, 20.0);
  auto shuffled = std::make_shared<SampleFrame>(*frame);
  std::vector<uint32_t> order(frame->size());
  std::iota(order.begin(), order.end(), 0u);
  std::shuffle(order.begin(), order.end(), std::mt19937(53));
  for (size_t i = 0; i < order.size(); ++i) {
    shuffled->samples[i] = frame->samples[order[i]];
    shuffled->colors[i] = frame->colors[order[i]];
  }
  for (const auto& [name, settings] : sphereTechniques()) {
    const WarpedImage a = stage.draw(name, frame, camera, settings), b = stage.draw(name, shuffled, camera, settings);
    size_t ties = 0;
    for (size_t i = 0; i < a.samples.size(); ++i) {
      const uint32_t before = a.samples[i], after = b.samples[i] == kNoSample ? kNoSample : order[b.samples[i]];
      if (before == after) continue;
      // Only two spheres that the ray meets at one distance may have changed places.
      ASSERT_TRUE(before != kNoSample && after != kNoSample) << name;
      const auto x = static_cast<float>(i % camera.width) + 0.5f, y = static_cast<float>(i / camera.width) + 0.5f;
      const Ray ray = pixelRay(camera, {x, y});
      const Sphere p = sphereOf(*frame, before), q = sphereOf(*frame, after);
      ASSERT_EQ(intersectSphere(ray, p.center, p.radius), intersectSphere(ray, q.center, q.radius)) << name;
      ++ties;
    }
    EXPECT_LT(ties, a.samples.size() / 50) << name;
  }
  recordExact("techniques, samples in another order", "itself, ties aside", GetParam());
}

TEST_P(Case54, DisocclusionsStayOpen) {
  // A small plate before a large one. From the server's place the small one hides the middle of the large one, which
  // the turned camera sees.
  const VolumePtr volume = makeTestVolume(VoxelType::uint8, {48, 48, 48}, [](const glm::ivec3& p) {
    const bool front = p.z == 40 && std::abs(p.x - 24) < 8 && std::abs(p.y - 24) < 8;
    const bool back = p.z == 8 && std::abs(p.x - 24) < 22 && std::abs(p.y - 24) < 22;
    return front || back ? 255.0 : 0.0;
  });
  const TransferFunction function{{{100.0, glm::vec3(1.0f), 0.0f}, {120.0, glm::vec3(1.0f), 1.0f}}};
  const MarcherPtr marcher = marcherOn(GetParam(), volume, function);
  Camera server;
  server.eye = {0.0f, 0.0f, 120.0f};
  server.tanHalfFovY = 0.3f;
  server.width = server.height = 128;
  const auto frame = std::make_shared<const SampleFrame>(marcher->march(server, {}));
  Camera client = server;
  const float angle = 0.35f;
  client.eye = 120.0f * glm::vec3(std::sin(angle), 0.0f, std::cos(angle));
  client.right = {std::cos(angle), 0.0f, -std::sin(angle)};
  client.forward = -glm::vec3(std::sin(angle), 0.0f, std::cos(angle));
  Image<glm::vec4> reference;
  marcher->render(client, {}, reference);

  for (const auto& [name, settings] : sphereTechniques()) {
    SCOPED_TRACE(name);
    const auto warp = techniqueOn(GetParam(), name);
    warp->setFrame(frame, settings);
    WarpedImage image;
    warp->draw(client, settings, image);
    const HoleCount count = countHoles(image, reference);
    EXPECT_GT(count.fraction(), 0.02);
    EXPECT_LT(count.fraction(), 0.3);
    // The middle of what the small plate hid: on the large one, where the line from the server's eye through the small
    // one's centre ends.
    const Projection hidden = project(client, {0.0f, 0.0f, 8.0f - 23.5f});
    const auto x = static_cast<uint32_t>(hidden.pixel.x), y = static_cast<uint32_t>(hidden.pixel.y);
    EXPECT_GT(reference(x, y).a, 0.9f);
    EXPECT_EQ(image.samples(x, y), kNoSample);
    for (size_t i = 0; i < image.samples.size(); ++i) {
      if (image.samples[i] == kNoSample) {
        ASSERT_EQ(image.color[i], glm::vec4(0.0f));
      }
    }
  }
  recordExact("disocclusions stay holes, uncovered pixels clear", "march", GetParam());
}

TEST_P(Case54, HolesGrowWithTheAngleAndAreNotPainted) {
  expectHolesGrowAndStayClear(stageOn(GetParam(), "block"), sphereTechniques());
  recordExact("holes of turned views: counted, not painted", "march", GetParam());
}

TEST_P(Case55, APictureOf8192By8192) {
  // From afar: the volume fills a million of the pixels, and the rays of the others end at once.
  Scene scene = smallScene("block");
  scene.views.front().distance = 8.0;
  const Stage stage(scene, gl::Platform::automatic, GetParam());
  const Camera camera = stage.camera(8192, 8192);
  const SampleFramePtr frame = stage.frame(camera, withRadius(stage.scene(), RadiusPolicy::pixel));
  ASSERT_GT(frame->size(), 200'000u);
  const WarpedImage image = stage.draw("splats", frame, camera);
  ASSERT_EQ(image.samples.size(), size_t{8192} * 8192);
  // Every sample in its own pixel, and nothing else.
  size_t wrong = 0;
  for (uint32_t i = 0; i < frame->size(); ++i)
    wrong += image.samples(columnOf(frame->samples[i]), rowOf(frame->samples[i])) != i;
  EXPECT_EQ(wrong, 0u);
  EXPECT_EQ(coveredPixels(image), frame->size());
  recordExact("splats of 8192x8192 pixels at the server's own camera", "the samples' pixels", GetParam());
}

TEST_P(Case66, AFrameOfOnePixel) {
  for (const BuiltinScene& builtin : builtinScenes()) {
    const Stage stage = stageOn(GetParam(), builtin.name);
    const Camera one = stage.camera(1, 1);
    const SampleFramePtr frame = stage.frame(one, withRadius(stage.scene(), RadiusPolicy::pixel));
    ASSERT_LE(frame->size(), 1u);
    expectRoundTrips(*frame, builtin.name);
    for (const auto& [name, settings] : sphereTechniques()) {
      const WarpedImage own = stage.draw(name, frame, one, settings);
      EXPECT_EQ(coveredPixels(own), frame->size()) << name;
      const WarpedImage large = stage.draw(name, frame, stage.camera(64, 48, 15.0), settings);
      EXPECT_EQ(coveredPixels(large) > 0, frame->size() > 0) << name;
      for (const uint32_t id : large.samples) EXPECT_TRUE(id == 0 || id == kNoSample);
    }
  }
  recordExact("a frame of one pixel: marched, coded, drawn", "definition", GetParam());
}

}  // namespace
}  // namespace warpscope
