// Techniques on the device against the CPU's sphere tracer, id for id: frames of scenes, random and degenerate clouds, none, one and many
// samples, near and far eyes, large footprints; pictures for the screen; errors.
// Mirrors render/warp/spheres_warp_cuda.h and splats_warp_cuda.h.
#include <gtest/gtest.h>

#include <array>
#include <span>

#include "app/picture/picture.h"
#include "render/base/error.h"
#include "render/cuda/devices.h"
#include "render/march/marcher_cpu.h"
#include "render/march/marcher_cuda.h"
#include "render/warp/lbvh/sphere_tracer.h"
#include "render/warp/multihit/nearest_hits.h"
#include "render/warp/multihit_warp.h"
#include "render/warp/multihit_warp_cuda.h"
#include "render/warp/spheres_warp.h"
#include "render/warp/spheres_warp_cuda.h"
#include "render/warp/splats_warp_cuda.h"
#include "tests/frame_samples.h"
#include "tests/gpu/agreement.h"
#include "tests/headless.h"
#include "tests/sphere_clouds.h"

namespace warpscope {
namespace {

struct Contender {
  std::string name;
  std::unique_ptr<Warp> warp;
  WarpSettings settings;
};

std::vector<Contender> contenders() {
  std::vector<Contender> all;
  WarpSettings settings;
  settings.knobs.set(kSphereTracingKnob, SphereTracing::clusters);
  all.push_back({"clusters", makeCudaSpheresWarp(), settings});
  for (const SphereTracing tracing : {SphereTracing::lbvh, SphereTracing::footprints, SphereTracing::automatic}) {
    settings.knobs.set(kSphereTracingKnob, tracing);
    all.push_back({std::string(nameOf(kSphereTracings, tracing)), makeCudaSpheresWarp(), settings});
  }
  all.push_back({"splats", makeCudaSplatsWarp(), {}});
  return all;
}

SampleFramePtr frameOf(const std::vector<Sphere>& cloud) {
  auto frame = std::make_shared<SampleFrame>(frameOfCloud(cloud));
  for (size_t i = 0; i < cloud.size(); ++i) frame->colors[i] = static_cast<Rgba8>(0xff000000u | (i * 2654435761u >> 8));
  return frame;
}

/// Both sides take the same formulas through the same rounding, so there is nothing to allow for.
void expectCpusIds(const SampleFramePtr& frame, const std::vector<Camera>& cameras, std::vector<Contender>& all) {
  std::vector<Sphere> spheres(frame->size());
  for (size_t i = 0; i < spheres.size(); ++i) spheres[i] = sphereOf(*frame, i);
  LbvhTracer tracer;
  tracer.build(spheres);
  for (Contender& contender : all) contender.warp->setFrame(frame, contender.settings);
  for (const Camera& camera : cameras) {
    WarpedImage expected;
    tracer.trace(camera, expected.samples, nullptr, {});
    resolveColors(*frame, expected.samples, expected.color);
    for (Contender& contender : all) {
      SCOPED_TRACE(contender.name);
      WarpedImage actual;
      contender.warp->draw(camera, contender.settings, actual);
      size_t different = 0;
      for (size_t i = 0; i < expected.samples.size(); ++i) different += expected.samples[i] != actual.samples[i];
      ASSERT_EQ(different, 0u) << "of " << expected.samples.size();
      ASSERT_TRUE(expected.color == actual.color);
    }
  }
}

TEST(WarpsOnDevice, FramesOfEveryScene) {
  WARPSCOPE_NEEDS_GPU();
  std::vector<Contender> all = contenders();
  for (const BuiltinScene& builtin : builtinScenes())
    for (const auto& radius : kRadiusPolicies) {
      SCOPED_TRACE(builtin.name + ", " + std::string(radius.name));
      const Scene scene = smallScene(builtin.name, 96);
      MarchSettings settings = scene.march;
      settings.sample.radiusPolicy = radius.value;
      const MarcherPtr marcher = makeCudaMarcher(scene.volume, scene.transferFunction);
      const auto frame = std::make_shared<SampleFrame>(marcher->march(makeCamera(scene, scene.views.front(), 400, 300), settings));
      ASSERT_GT(frame->size(), 1000u);
      std::vector<Camera> cameras;
      for (const View& view : scene.views) cameras.push_back(makeCamera(scene, view, 333, 277));
      expectCpusIds(frame, cameras, all);
    }
}

TEST(WarpsOnDevice, CloudsOfEveryShapeAndSize) {
  WARPSCOPE_NEEDS_GPU();
  std::vector<Contender> all = contenders();
  for (const CloudShape shape : kCloudShapes)
    for (const size_t count : {size_t{0}, size_t{1}, size_t{2}, size_t{3}, size_t{31}, size_t{32}, size_t{33}, size_t{1023}, size_t{1025},
                               size_t{40000}}) {
      SCOPED_TRACE(::testing::Message() << "shape " << static_cast<int>(shape) << ", " << count << " spheres");
      const SampleFramePtr frame = frameOf(makeCloud(shape, count, 100.0f, 7 + static_cast<uint32_t>(count)));
      // From outside, from inside, and from so far that all of it is a few pixels.
      std::vector<Camera> cameras{orbitCamera(300.0f, 20.0f, 193, 161), orbitCamera(5.0f, 100.0f, 97, 101), orbitCamera(1e5f, 0.0f, 64, 64)};
      cameras.push_back(orbitCamera(300.0f, 45.0f, 1, 1));
      expectCpusIds(frame, cameras, all);
    }
}

/// Of the frame that both have.
void expectSamePictures(Warp& onCpu, std::span<const std::unique_ptr<Warp>> onDevice, const Camera& camera, const WarpSettings& settings) {
  WarpedImage expected, actual;
  onCpu.draw(camera, settings, expected);
  for (size_t k = 0; k < onDevice.size(); ++k) {
    SCOPED_TRACE(k);
    onDevice[k]->draw(camera, settings, actual);
    ASSERT_TRUE(expected.samples == actual.samples);
    ASSERT_TRUE(expected.color == actual.color);
  }
}

/// `multihit` by footprints, through clusters, and by what is faster.
std::array<std::unique_ptr<Warp>, 3> everyWay() {
  return {makeCudaMultihitWarp(SphereTracing::footprints), makeCudaMultihitWarp(SphereTracing::clusters), makeCudaMultihitWarp()};
}

/// Marched frames of one and of several samples a ray, in their own view, beside it, behind it, and close to them.
TEST(WarpsOnDevice, SurfacesAreTheCpus) {
  WARPSCOPE_NEEDS_GPU();
  const std::unique_ptr<Warp> onCpu = makeWarp(findWarp("multihit"), {});
  const auto onDevice = everyWay();
  for (const BuiltinScene& builtin : builtinScenes())
    for (const int samplesPerRay : {1, 3}) {
      const Scene scene = smallScene(builtin.name, 96);
      MarchSettings march = scene.march;
      march.sample.samplesPerRay = samplesPerRay;
      const MarcherPtr marcher = makeCudaMarcher(scene.volume, scene.transferFunction);
      View view = scene.views.front();
      const auto frame = std::make_shared<SampleFrame>(marcher->march(makeCamera(scene, view, 400, 300), march));
      onCpu->setFrame(frame, {});
      for (const auto& warp : onDevice) warp->setFrame(frame, {});
      for (const double turn : {0.0, 12.0, 45.0, 170.0})
        for (const int hits : {1, 2, 4, kMaxHits}) {
          SCOPED_TRACE(builtin.name + ", " + std::to_string(samplesPerRay) + " samples a ray, " + std::to_string(turn) + " degrees, " + std::to_string(hits) + " hits");
          view.angleDeg = scene.views.front().angleDeg + turn;
          WarpSettings settings;
          settings.knobs.set(kHitsKnob, hits);
          ASSERT_NO_FATAL_FAILURE(expectSamePictures(*onCpu, onDevice, turn == 0.0 ? frame->camera : makeCamera(scene, view, 333, 277), settings));
        }
      view.distance *= 0.3;  // among them
      ASSERT_NO_FATAL_FAILURE(expectSamePictures(*onCpu, onDevice, makeCamera(scene, view, 333, 277), {}));
    }
}

/// Pieces' own pixels are bounded for bases that are one: others take their spheres'.
TEST(WarpsOnDevice, SurfacesOfAFrameWhoseBasisIsSlightlyOff) {
  WARPSCOPE_NEEDS_GPU();
  const Scene scene = smallScene("shells", 96);
  const MarcherPtr marcher = makeCudaMarcher(scene.volume, scene.transferFunction);
  auto frame = std::make_shared<SampleFrame>(marcher->march(makeCamera(scene, scene.views.front(), 400, 300), scene.march));
  frame->camera.up += 1e-4f * frame->camera.right;
  ASSERT_TRUE(isUsable(frame->camera));
  const std::unique_ptr<Warp> onCpu = makeWarp(findWarp("multihit"), {});
  const auto onDevice = everyWay();
  onCpu->setFrame(frame, {});
  for (const auto& warp : onDevice) warp->setFrame(frame, {});
  for (const View& view : scene.views) ASSERT_NO_FATAL_FAILURE(expectSamePictures(*onCpu, onDevice, makeCamera(scene, view, 333, 277), {}));
}

/// One warp each, whatever stood before: another way, another smear, another frame, a build that failed.
TEST(WarpsOnDevice, WaysFollowOneAnother) {
  WARPSCOPE_NEEDS_GPU();
  const std::unique_ptr<Warp> onCpu = makeWarp(findWarp("spheres"), {}), onDevice = makeCudaSpheresWarp();
  const auto settingsOf = [](SphereTracing tracing, double smear) {
    WarpSettings settings;
    settings.knobs.set(kSphereTracingKnob, tracing);
    settings.knobs.set(kSmearKnob, smear);
    return settings;
  };
  using enum SphereTracing;
  for (const char* name : {"block", "shells", "vessels"}) {
    const Scene scene = smallScene(name, 96);
    MarchSettings march = scene.march;
    march.sample.sendsSpread = true;
    const MarcherPtr marcher = makeCudaMarcher(scene.volume, scene.transferFunction);
    const auto frame = std::make_shared<SampleFrame>(marcher->march(makeCamera(scene, scene.views.front(), 400, 300), march));
    onCpu->setFrame(frame, {});
    onDevice->setFrame(frame, settingsOf(footprints, 0.0));
    const Camera camera = makeCamera(scene, scene.views.back(), 333, 277);
    int step = 0;
    for (const auto& [tracing, smear] : {std::pair{clusters, 0.0}, {lbvh, 0.0}, {footprints, 0.0}, {clusters, 0.0}, {automatic, 0.5}, {lbvh, 0.5}, {lbvh, 0.0}, {automatic, 0.0}, {lbvh, 2.0},
                                         {clusters, 0.0}}) {
      SCOPED_TRACE(std::string(name) + ", step " + std::to_string(step++));
      WarpedImage expected, actual;
      onCpu->draw(camera, settingsOf(automatic, smear), expected);
      onDevice->draw(camera, settingsOf(tracing, smear), actual);
      ASSERT_TRUE(expected.samples == actual.samples);
    }
  }
}

/// Samples that no marcher made: several rays in a pixel, none, few.
TEST(WarpsOnDevice, SurfacesOfCloudsAreTheCpus) {
  WARPSCOPE_NEEDS_GPU();
  const std::unique_ptr<Warp> onCpu = makeWarp(findWarp("multihit"), {});
  const auto onDevice = everyWay();
  for (const CloudShape shape : kCloudShapes)
    for (const size_t count : {size_t{0}, size_t{1}, size_t{33}, size_t{4000}}) {
      SCOPED_TRACE(::testing::Message() << "shape " << static_cast<int>(shape) << ", " << count << " samples");
      const std::vector<Sphere> cloud = makeCloud(shape, count, 100.0f, 11);
      auto frame = std::make_shared<SampleFrame>(frameOfSpheres(cloud, 16.0f, 4.0f, 63, 512.0f));
      for (size_t i = 0; i < frame->size(); ++i) frame->colors[i] = static_cast<Rgba8>(i * 2654435761u);
      onCpu->setFrame(frame, {});
      for (const auto& warp : onDevice) warp->setFrame(frame, {});
      for (const Camera& camera : {frame->camera, orbitCamera(300.0f, 20.0f, 193, 161), orbitCamera(5.0f, 100.0f, 97, 101)}) {
        ASSERT_NO_FATAL_FAILURE(expectSamePictures(*onCpu, onDevice, camera, {}));
      }
    }
}

/// Both sides build the hierarchy by the same rules and meet capsules by the same formula.
TEST(WarpsOnDevice, CapsulesAreTheCpus) {
  WARPSCOPE_NEEDS_GPU();
  const std::unique_ptr<Warp> onCpu = makeWarp(findWarp("spheres"), {});
  const std::unique_ptr<Warp> onDevice = makeCudaSpheresWarp();
  for (const BuiltinScene& builtin : builtinScenes()) {
    const Scene scene = smallScene(builtin.name, 96);
    MarchSettings march = scene.march;
    march.sample.sendsSpread = true;
    const MarcherPtr marcher = makeCudaMarcher(scene.volume, scene.transferFunction);
    const auto frame = std::make_shared<SampleFrame>(marcher->march(makeCamera(scene, scene.views.front(), 400, 300), march));
    onCpu->setFrame(frame, {});
    onDevice->setFrame(frame, {});
    for (const View& view : scene.views)
      for (const double smear : {0.0, 0.5, 4.0}) {
        SCOPED_TRACE(builtin.name + ", smeared by " + std::to_string(smear));
        WarpSettings settings;
        settings.knobs.set(kSmearKnob, smear);
        ASSERT_NO_FATAL_FAILURE(expectSamePictures(*onCpu, {&onDevice, 1}, makeCamera(scene, view, 333, 277), settings));
      }
  }
}

TEST(WarpsOnDevice, NearSpheresThatFillTheScreen) {
  WARPSCOPE_NEEDS_GPU();
  std::vector<Contender> all = contenders();
  std::vector<Sphere> cloud = makeCloud(CloudShape::random, 500, 100.0f, 3);
  const Camera camera = orbitCamera(300.0f, 0.0f, 700, 500);
  cloud.push_back({camera.eye + 12.0f * camera.forward, 10.0f});                       // all of the screen
  cloud.push_back({camera.eye + 12.0f * camera.forward + 9.0f * camera.right, 8.0f});  // a part of it
  cloud.push_back({camera.eye + 2.0f * camera.right, 1.9f});                           // beside the eye
  cloud.push_back({camera.eye, 1.0f});                                                 // holds it
  expectCpusIds(frameOf(cloud), {camera}, all);
}

TEST(WarpsOnDevice, TheScreensPictureIsTheHosts) {
  WARPSCOPE_NEEDS_GPU();
  const SampleFramePtr frame = frameOf(makeCloud(CloudShape::clustered, 3000, 100.0f, 5));
  const Camera camera = orbitCamera(300.0f, 20.0f, 193, 161);
  const glm::vec3 background(0.1f, 0.02f, 0.3f);
  for (Contender& contender : contenders()) {
    SCOPED_TRACE(contender.name);
    EXPECT_EQ(contender.warp->drawForScreen(camera, contender.settings, background, {}), nullptr);  // no frame yet
    contender.warp->setFrame(frame, contender.settings);
    WarpedImage image;
    contender.warp->draw(camera, contender.settings, image);
    for (const Rgba8 uncovered : {0u, 0xffff00ffu}) {
      const DevicePicturePtr picture = contender.warp->drawForScreen(camera, contender.settings, background, {.uncovered = uncovered});
      ASSERT_NE(picture, nullptr);
      Image<Rgba8> downloaded(picture->width(), picture->height());
      picture->download({downloaded.data(), downloaded.size()});
      EXPECT_TRUE(downloaded == toScreen(image, background, {.uncovered = uncovered}));
    }
    ASSERT_TRUE(contender.warp->deviceTimings());
    EXPECT_GT(contender.warp->deviceTimings()->drawMs, 0.0);
  }
}

TEST(WarpsOnDevice, PicturesThatAreStillShownAreNotDrawnInto) {
  WARPSCOPE_NEEDS_GPU();
  for (Contender& contender : contenders()) {
    contender.warp->setFrame(frameOf(makeCloud(CloudShape::random, 3000, 100.0f, 5)), contender.settings);
    const auto drawn = [&](float angle) {
      return contender.warp->drawForScreen(orbitCamera(300.0f, angle, 90, 80), contender.settings, {}, {});
    };
    const auto pixelsOf = [](const DevicePicturePtr& picture) {
      std::vector<Rgba8> pixels(size_t{picture->width()} * picture->height());
      picture->download(pixels);
      return pixels;
    };
    const DevicePicturePtr first = drawn(0.0f);
    const std::vector<Rgba8> before = pixelsOf(first);
    const DevicePicturePtr second = drawn(50.0f);
    EXPECT_NE(pixelsOf(second), before);
    EXPECT_EQ(pixelsOf(first), before);
  }
}

TEST(WarpsOnDevice, RefuseAndGoOn) {
  WARPSCOPE_NEEDS_GPU();
  for (Contender& contender : contenders()) {
    contender.warp->setFrame(frameOf(makeCloud(CloudShape::random, 100, 100.0f, 5)), contender.settings);
    Camera camera = orbitCamera(300.0f, 0.0f, 64, 64);
    WarpedImage image;
    std::stop_source stop;
    stop.request_stop();
    EXPECT_THROW(contender.warp->draw(camera, contender.settings, image, stop.get_token()), OperationCancelled);
    camera.eye.y = std::nanf("");
    EXPECT_THROW(contender.warp->draw(camera, contender.settings, image), InputError);
    camera = orbitCamera(300.0f, 0.0f, 64, 64);
    contender.warp->draw(camera, contender.settings, image);
    EXPECT_TRUE(std::ranges::any_of(image.samples, [](uint32_t sample) { return sample < 100; }));
    contender.warp->setFrame(nullptr, contender.settings);
    contender.warp->draw(camera, contender.settings, image);
    EXPECT_TRUE(std::ranges::all_of(image.samples, [](uint32_t sample) { return sample == kNoSample; }));
  }
}

TEST(WarpsOnDevice, EmbreeIsForTheCpu) {
  WARPSCOPE_NEEDS_GPU();
  WarpSettings settings;
  settings.knobs.set(kSphereTracingKnob, SphereTracing::embree);
  EXPECT_THROW(makeCudaSpheresWarp()->setFrame(frameOf({}), settings), UsageError);
}

/// Ten million samples: a frame of 4096 x 4096 pixels of a scene that fills most of it.
TEST(WarpsOnDevice, TenMillionSamples) {
  WARPSCOPE_NEEDS_GPU();
  const Scene scene = smallScene("shells", 128);
  const MarcherPtr marcher = makeCudaMarcher(scene.volume, scene.transferFunction);
  View near = scene.views.front();
  near.distance *= 0.7;
  const auto frame = std::make_shared<SampleFrame>(marcher->march(makeCamera(scene, near, 4096, 4096), scene.march));
  ASSERT_GT(frame->size(), 10'000'000u);
  std::vector<Contender> all = contenders();
  expectCpusIds(frame, {makeCamera(scene, scene.views[1], 512, 512)}, all);
}

}  // namespace
}  // namespace warpscope
