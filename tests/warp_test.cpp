// Techniques: the identity in the server's own view, culling, ties, holes, and what every technique owes its caller.
// Mirrors render/warp/warp.h.
#include "render/warp/warp.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cstring>
#include <limits>
#include <set>

#include "render/base/error.h"
#include "render/core/ray_sphere.h"
#include "render/metrics/holes.h"
#include "render/metrics/psnr.h"
#include "render/warp/multihit_warp.h"
#include "render/warp/points_warp.h"
#include "render/warp/spheres_warp.h"
#include "tests/frame_samples.h"
#include "tests/headless.h"
#include "tests/held_frame.h"
#include "tests/warp_cases.h"

namespace warpscope {
namespace {

// --- The server's own view

class WarpGl : public OnPlatform {};
INSTANTIATE_TEST_SUITE_P(Gl, WarpGl, bothPlatforms(), platformName);

TEST_P(WarpGl, PointsShowEveryPixelItsOwnSample) {
  for (const BuiltinScene& builtin : builtinScenes()) {
    const Stage stage(smallScene(builtin.name), GetParam());
    for (const glm::uvec2& size : kOddSizes) {
      SCOPED_TRACE(builtin.name + " " + std::to_string(size.x) + "x" + std::to_string(size.y));
      const Camera camera = stage.camera(size.x, size.y);
      const SampleFramePtr frame = stage.frame(camera, stage.scene().march);
      WarpSettings settings;
      settings.knobs.set(kPointSizeKnob, 1);
      expectExactly(stage.draw("points", frame, camera, settings), ownPixels(*frame), *frame);
    }
  }
}

/// Every sample has a pixel of its own: nothing is lost between the march and ownPixels, which the tests above rely on.
TEST(Warp, EverySampleLiesInItsOwnPixelInOrder) {
  for (const BuiltinScene& builtin : builtinScenes()) {
    const Stage stage(smallScene(builtin.name));
    const SampleFramePtr frame = stage.frame(stage.camera(333, 217), stage.scene().march);
    ASSERT_GT(frame->size(), 1000u) << builtin.name;
    std::vector<uint32_t> seen;
    for (const uint32_t id : ownPixels(*frame))
      if (id != kNoSample) seen.push_back(id);
    ASSERT_EQ(seen.size(), frame->size()) << builtin.name;
    for (uint32_t i = 0; i < seen.size(); ++i) ASSERT_EQ(seen[i], i) << builtin.name;
  }
}

/// With the paper's radius neighbours cover a pixel's own sample: then the seen one must be no farther than the pixel's own.
TEST(Warp, SpheresOfVoxelRadiusNeverShowWhatIsBehindAPixelsOwnSample) {
  for (const BuiltinScene& builtin : builtinScenes()) {
    const Stage stage(smallScene(builtin.name));
    const Camera camera = stage.camera(333, 217);
    const SampleFramePtr frame = stage.frame(camera, withRadius(stage.scene(), RadiusPolicy::voxel));
    const Image<uint32_t> own = ownPixels(*frame);
    const WarpedImage image = stage.draw("spheres", frame, camera);
    size_t uncovered = 0, farther = 0;
    for (uint32_t y = 0; y < camera.height; ++y)
      for (uint32_t x = 0; x < camera.width; ++x) {
        if (own(x, y) == kNoSample) continue;
        if (image.samples(x, y) == kNoSample) {
          ++uncovered;
          continue;
        }
        const Ray ray = pixelRay(camera, {static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f});
        const Sphere ownSphere = sphereOf(*frame, own(x, y)), seen = sphereOf(*frame, image.samples(x, y));
        farther += intersectSphere(ray, seen.center, seen.radius) > intersectSphere(ray, ownSphere.center, ownSphere.radius);
      }
    EXPECT_EQ(uncovered, 0u) << builtin.name;
    EXPECT_EQ(farther, 0u) << builtin.name;
  }
}

TEST(Warp, ReferenceShowsTheServersColoursUpToRounding) {
  const Stage stage(smallScene("shells"));
  const Camera camera = stage.camera(160, 120);
  const SampleFramePtr frame = stage.frame(camera, stage.scene().march);
  WarpSettings settings;
  settings.reference = stage.scene().march.render;
  const WarpedImage reference = stage.draw("reference", nullptr, camera, settings);
  const Image<uint32_t> own = ownPixels(*frame);
  for (size_t i = 0; i < own.size(); ++i) {
    ASSERT_EQ(reference.samples[i], kNotASample);
    if (own[i] == kNoSample) continue;
    ASSERT_EQ(ColorTables::instance().encode(reference.color[i]), frame->colors[own[i]]) << "pixel " << i;
  }
}

// --- Sizes

TEST_P(WarpGl, LargeImages) {
  // From afar: the volume fills a few hundred thousand of the pixels, and the rays of the others end at once.
  Scene scene = smallScene("block");
  scene.views.front().distance = 4.0;
  const Stage stage(scene, GetParam());
  const Camera camera = stage.camera(4096, 4096);
  const SampleFramePtr frame = stage.frame(camera, stage.scene().march);
  ASSERT_GT(frame->size(), 200'000u);
  const Image<uint32_t> own = ownPixels(*frame);
  WarpSettings settings;
  settings.knobs.set(kPointSizeKnob, 1);
  expectExactly(stage.draw("points", frame, camera, settings), own, *frame);
  if (GetParam() == gl::Platform::egl) expectExactly(stage.draw("hold", frame, camera), own, *frame);
}

TEST_P(WarpGl, FramesOfNoneOneAndTwoSamples) {
  const Stage stage = syntheticStage(GetParam());
  const Camera camera = frontCamera(65, 33);
  const std::vector<Sphere> spheres{{{0.0f, 0.0f, 0.0f}, 0.25f}, {{2.0f, 1.0f, 0.0f}, 0.25f}};
  for (const WarpDescriptor& technique : warpRegistry()) {
    if (!showsSamplesAsTheyAre(technique)) continue;
    for (size_t count = 0; count <= 2; ++count) {
      SCOPED_TRACE(std::string(technique.name) + " " + std::to_string(count));
      const SampleFramePtr frame = makeFrame({spheres.begin(), spheres.begin() + static_cast<ptrdiff_t>(count)});
      const WarpedImage image = stage.draw(technique.name, frame, camera);
      std::set<uint32_t> seen;
      for (size_t i = 0; i < image.samples.size(); ++i) {
        if (image.samples[i] == kNoSample) {
          ASSERT_EQ(image.color[i], glm::vec4(0.0f));
          continue;
        }
        seen.insert(image.samples[i]);
        ASSERT_EQ(image.color[i], decodeRgba8(frame->colors[image.samples[i]]));
      }
      std::set<uint32_t> expected;
      for (uint32_t i = 0; i < count; ++i) expected.insert(i);
      EXPECT_EQ(seen, expected);
    }
  }
}

// --- Frames on a device

/// With a device that is none: what it holds is the host's to fetch.
TEST_P(WarpGl, FramesThatADeviceHoldsAreDrawnAsThoseThatAreHere) {
  const Stage stage(smallScene("shells"), GetParam());
  MarchSettings settings = stage.scene().march;
  settings.sample.segments = 3;
  const SampleFramePtr here = stage.frame(stage.camera(65, 43), settings);
  ASSERT_GT(here->segments.size(), 1000u);
  const auto there = std::make_shared<const SampleFrame>(leftOnDevice(*here));
  const Camera turned = stage.camera(60, 50, 20.0);
  for (const WarpDescriptor& technique : warpRegistry()) {
    if (!technique.usesFrame) continue;
    SCOPED_TRACE(technique.name);
    const WarpedImage expected = stage.draw(technique.name, here, turned), image = stage.draw(technique.name, there, turned);
    EXPECT_TRUE(image.samples == expected.samples);
    EXPECT_TRUE(image.color == expected.color);
    EXPECT_GT(coveredPixels(image), 500u);
    EXPECT_THROW(stage.draw(technique.name, std::make_shared<const SampleFrame>(leftOnDevice(*here, true)), turned), DeviceError);
  }
}

// --- Several samples a pixel

TEST_P(WarpGl, OfTwoSamplesAPixelTheNearerIsSeenInEitherOrder) {
  const Stage stage = syntheticStage(GetParam());
  const Camera camera = frontCamera(8, 8);
  const auto frameOf = [&](std::initializer_list<float> depths) {
    SampleFrame frame;
    frame.camera = camera;
    frame.quantization = {{glm::vec3(-16.0f), glm::vec3(16.0f)}, 1.0f, 0.0f, 1.0f / 64.0f};
    for (uint32_t y = 0; y < camera.height; ++y)
      for (uint32_t x = 0; x < camera.width; ++x)
        for (const float depth : depths) {
          frame.samples.push_back(packSample(x, y, depth, 0.125f, frame.quantization));
          frame.colors.push_back(0xff000000u | static_cast<uint32_t>(frame.samples.size()));
        }
    return std::make_shared<const SampleFrame>(std::move(frame));
  };
  const SampleFramePtr nearFirst = frameOf({8.0f, 12.0f}), farFirst = frameOf({12.0f, 8.0f});
  WarpSettings settings;
  settings.knobs.set(kPointSizeKnob, 1);
  for (const std::string_view technique : {"hold", "points", "spheres"})
    for (const uint32_t nearer : {0u, 1u}) {
      SCOPED_TRACE(std::string(technique) + (nearer == 0 ? ", nearer first" : ", farther first"));
      const WarpedImage image = stage.draw(technique, nearer == 0 ? nearFirst : farFirst, camera, settings);
      for (uint32_t i = 0; i < image.samples.size(); ++i) ASSERT_EQ(image.samples[i], 2 * i + nearer) << "pixel " << i;
    }
}

// --- At or behind the eye

TEST_P(WarpGl, NothingAtOrBehindTheEyeIsSeen) {
  const Stage stage = syntheticStage(GetParam());
  const Camera camera = frontCamera(64, 64);
  // At the eye; in its plane to all sides; behind it; behind it and far off the axis.
  const SampleFramePtr frame =
      makeFrame({{{0.0f, 0.0f, 10.0f}, 0.5f}, {{1.0f, 0.0f, 10.0f}, 0.5f}, {{0.0f, -1.0f, 10.0f}, 0.5f},
                         {{0.0f, 0.0f, 12.0f}, 1.0f}, {{0.5f, -0.5f, 30.0f}, 1.0f}, {{100.0f, 0.0f, 11.0f}, 1.0f}},
                1.0f / 32.0f, 8191);
  for (const WarpDescriptor& technique : warpRegistry()) {
    if (!technique.uses.depth) continue;  // others show what the frame's own camera sees
    WarpSettings settings;
    settings.knobs.set(kPointSizeKnob, 16);
    EXPECT_EQ(coveredPixels(stage.draw(technique.name, frame, camera, settings)), 0u) << technique.name;
  }
}

/// A sphere that holds the eye is looked through; one in front of it is not.
TEST(Warp, SpheresAroundTheEyeAreSeenHalfwayToTheirCentres) {
  const Stage stage = syntheticStage();
  const Camera camera = frontCamera(64, 64);
  const SampleFramePtr frame = makeFrame({{{0.0f, 0.0f, 9.5f}, 2.0f}, {{0.0f, 0.0f, 0.0f}, 4.0f}});
  for (const char* technique : {"spheres", "splats", "multihit", "sprites"}) {
    const WarpedImage image = stage.draw(technique, frame, camera);
    EXPECT_EQ(image.samples(32, 32), 0u) << technique;
    // It keeps to the samples' own pixels.
    if (std::string_view(technique) != "multihit") {
      EXPECT_EQ(image.samples, stage.draw("spheres", frame, camera).samples) << technique;
    }
  }
}

// --- Equal depths

TEST_P(WarpGl, OfEqualDepthsTheLowerIdIsSeenWhateverTheThreads) {
  const Stage stage = syntheticStage(GetParam());
  const Camera camera = frontCamera(96, 80);
  std::vector<Sphere> spheres;
  for (int copy = 0; copy < 3; ++copy)
    for (int y = -12; y <= 12; ++y)
      for (int x = -12; x <= 12; ++x) spheres.push_back({{0.25f * static_cast<float>(x), 0.25f * static_cast<float>(y), 0.0f}, 0.25f});
  const SampleFramePtr frame = makeFrame(spheres);
  const uint32_t originals = 25 * 25;
  for (const WarpDescriptor& technique : warpRegistry()) {
    if (!showsSamplesAsTheyAre(technique)) continue;
    WarpedImage first;
    for (const size_t threads : {1, 2, 5}) {
      SCOPED_TRACE(std::string(technique.name) + ", " + std::to_string(threads) + " threads");
      const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
      WarpedImage image = stage.draw(technique.name, frame, camera);
      ASSERT_GT(coveredPixels(image), 500u);
      for (const uint32_t id : image.samples) ASSERT_TRUE(id == kNoSample || id < originals) << id;
      if (threads == 1) first = image;
      EXPECT_EQ(image.samples, first.samples);
      EXPECT_EQ(image.color, first.color);
    }
  }
}

// --- Disocclusions

TEST_P(WarpGl, DisocclusionsAreHolesAndNotBackground) {
  expectHolesGrowAndStayClear(Stage(smallScene("block"), GetParam()), {{"points", {}}, {"spheres", {}}});
}

/// What spheres are for. At small angles the paper's radius may cost more than the holes that it closes; at larger ones it pays.
TEST_P(WarpGl, SpheresCloseHolesThatPointsLeave) {
  const Stage stage(openScene("block"), GetParam());
  const uint32_t side = 512;
  const SampleFramePtr frame = stage.frame(stage.camera(side, side), stage.scene().march);
  for (const double turn : {10.0, 25.0, 45.0}) {
    const Camera turned = stage.camera(side, side, turn);
    Image<glm::vec4> reference;
    stage.marcher().render(turned, stage.scene().march.render, reference);
    const auto measure = [&](std::string_view technique) {
      const WarpedImage image = stage.draw(technique, frame, turned);
      return std::pair(psnrSrgb(image.color, reference, stage.scene().background), countHoles(image, reference).fraction());
    };
    const auto [spheresDb, spheresHoles] = measure("spheres");
    const auto [pointsDb, pointsHoles] = measure("points");
    const auto [holdDb, holdHoles] = measure("hold");
    EXPECT_LT(spheresHoles, pointsHoles) << turn;
    EXPECT_GT(pointsDb, holdDb) << turn;
    EXPECT_GT(spheresDb, holdDb) << turn;
    EXPECT_TRUE(turn < 20.0 || spheresDb > pointsDb) << turn << ": " << spheresDb << " " << pointsDb;
  }
}

// --- What every technique owes its caller

TEST(Warp, ResolvedColoursAreTheSamples) {
  SampleFrame frame;
  for (uint32_t i = 0; i < 35; ++i) frame.colors.push_back(0x01010101u * i * 7);
  frame.samples.resize(frame.colors.size(), 1);
  Image<uint32_t> samples(7, 5);
  for (uint32_t i = 0; i < 35; ++i) samples[i] = 34 - i;
  samples[3] = kNoSample;
  samples[4] = kNotASample;
  samples[5] = 35;  // one past the end
  Image<glm::vec4> color(2, 2, glm::vec4(9.0f));
  resolveColors(frame, samples, color);
  ASSERT_EQ(color.width(), 7u);
  ASSERT_EQ(color.height(), 5u);
  for (uint32_t i = 0; i < 35; ++i) {
    const bool isSample = i < 3 || i > 5;
    EXPECT_EQ(color[i], isSample ? decodeRgba8(frame.colors[34 - i]) : glm::vec4(0.0f)) << i;
  }
}

TEST_P(WarpGl, UnusableCamerasAreRefusedAndTheTechniqueLivesOn) {
  const Stage stage = syntheticStage(GetParam());
  const Camera good = frontCamera(40, 30);
  const SampleFramePtr frame = makeFrame({{{0.0f, 0.0f, 0.0f}, 1.0f}});
  const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
  std::vector<Camera> bad(12, good);
  bad[0].eye.x = nan;
  bad[1].eye.z = inf;
  bad[2].tanHalfFovY = 0.0f;
  bad[3].tanHalfFovY = nan;
  bad[4].tanHalfFovY = inf;
  bad[5].width = 0;
  bad[6].height = kMaxImageSide + 1;
  bad[7].forward = glm::vec3(0.0f);
  bad[8].up = bad[8].forward;  // up parallel to the view
  bad[9].right *= 2.0f;
  bad[10].up.y = nan;
  bad[11].tanHalfFovY = -1.0f;
  for (const WarpDescriptor& technique : warpRegistry()) {
    const std::unique_ptr<Warp> warp = technique.make(stage.resources());
    warp->setFrame(frame, {});
    WarpedImage before, image;
    warp->draw(good, {}, before);
    for (size_t i = 0; i < bad.size(); ++i)
      EXPECT_THROW(warp->draw(bad[i], {}, image), InputError) << technique.name << ", camera " << i;
    warp->draw(good, {}, image);
    EXPECT_EQ(image.samples, before.samples) << technique.name;
    EXPECT_EQ(image.color, before.color) << technique.name;
  }
}

TEST_P(WarpGl, WithoutAFrameNothingIsCovered) {
  const Stage stage = syntheticStage(GetParam());
  const Camera camera = frontCamera(33, 21);
  const SampleFramePtr frame = makeFrame({{{0.0f, 0.0f, 0.0f}, 1.0f}});
  for (const WarpDescriptor& technique : warpRegistry()) {
    if (!drawsSamples(technique)) continue;  // these frames have nothing else
    SCOPED_TRACE(technique.name);
    const std::unique_ptr<Warp> warp = technique.make(stage.resources());
    WarpedImage image;
    warp->draw(camera, {}, image);  // before any frame
    EXPECT_EQ(coveredPixels(image), 0u);
    warp->setFrame(frame, {});
    warp->draw(camera, {}, image);
    EXPECT_GT(coveredPixels(image), 0u);
    warp->setFrame(nullptr, {});
    warp->draw(frontCamera(11, 12), {}, image);
    EXPECT_EQ(coveredPixels(image), 0u);
    EXPECT_EQ(image.samples.width(), 11u);
    EXPECT_EQ(image.color.height(), 12u);
    for (const glm::vec4& color : image.color) ASSERT_EQ(color, glm::vec4(0.0f));
  }
}

TEST(Warp, SettingsOutOfRangeAreRefused) {
  WarpSettings settings;
  for (const Knob* knob : {&kPointSizeKnob, &kHitsKnob}) {
    for (const double value : {0.0, 17.0, -1.0, 2.5}) EXPECT_THROW(settings.knobs.set(*knob, value), UsageError) << knob->key << " " << value;
    EXPECT_EQ(settings.knobs[*knob], knob->defaultValue);  // as it was
    EXPECT_NO_THROW(settings.knobs.set(*knob, 16));
  }
  EXPECT_THROW(settings.knobs.set(kSphereTracingKnob, static_cast<int>(kSphereTracings.size())), UsageError);
  EXPECT_NO_THROW(validate(settings));
  settings.reference.step = 0.0f;
  EXPECT_THROW(validate(settings), UsageError);
}

TEST(Warp, NamesAreUniqueAndWrongOnesAreAnsweredWithTheNearest) {
  std::set<std::string_view> names;
  for (const WarpDescriptor& technique : warpRegistry()) {
    EXPECT_TRUE(names.insert(technique.name).second) << technique.name;
    EXPECT_EQ(&findWarp(technique.name), &technique);
  }
  try {
    findWarp("sphere");
    FAIL() << "found";
  } catch (const UsageError& error) {
    EXPECT_NE(std::strstr(error.what(), "spheres"), nullptr) << error.what();
  }
}

}  // namespace
}  // namespace warpscope
