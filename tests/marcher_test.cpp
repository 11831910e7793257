// The CPU's marcher: what its frames say, how it is cancelled, what it refuses. What it shows of hard volumes: stability/volumes_test.cpp.
// Mirrors render/march/marcher_cpu.h.
#include "render/march/marcher_cpu.h"

#include <gtest/gtest.h>

#include <cmath>
#include <thread>

#include "marcher_cases.h"
#include "render/base/error.h"
#include "test_volumes.h"
#include "tests/frame_samples.h"

namespace warpscope {
namespace {

VolumePtr constantVolume(VoxelType type, const glm::uvec3& dims, double value = 50.0) {
  return makeTestVolume(type, dims, [=](const glm::ivec3&) { return value; });
}

TEST(CpuMarcher, FramesSayWhatTheyAreMadeFor) {
  const MarcherPtr marcher = makeCpuMarcher(constantVolume(VoxelType::uint8, {16, 12, 10}), everywhere(0.5f));
  const Camera camera = lookingFrom({30.0f, 10.0f, 20.0f}, {}, 50, 40);
  MarchSettings settings;
  settings.sample.heuristic = Heuristic::median;
  for (const auto& policy : kRadiusPolicies) {
    settings.sample.radiusPolicy = policy.value;
    const SampleFrame frame = marcher->march(camera, settings);
    EXPECT_EQ(frame.camera, camera);
    EXPECT_EQ(frame.settings, settings);
    EXPECT_EQ(frame.voxelRadius, 0.5f * glm::length(marcher->volume()->geometry().voxelEdges()));
    EXPECT_EQ(frame.requestId, 0u);
    EXPECT_EQ(frame.quantization.bounds, marcher->volume()->bounds());
    ASSERT_EQ(frame.samples.size(), frame.colors.size());
    for (size_t i = 0; i < frame.size(); ++i) {
      const Sphere sphere = sphereOf(frame, i);
      const double pixel = 0.5 * 2.0 * 0.4 / 40.0 * glm::dot(sphere.center - camera.eye, camera.forward);
      const double voxel = 0.5 * std::sqrt(3.0);
      double lowest = pixel, highest = pixel;
      if (policy.value == RadiusPolicy::voxel) lowest = highest = voxel;
      if (policy.value == RadiusPolicy::constant) lowest = highest = 0.5;
      if (policy.value == RadiusPolicy::opacity) lowest = std::min(pixel, voxel), highest = voxel;
      if (policy.value == RadiusPolicy::uncertainty) lowest = voxel, highest = 2.0 * voxel;
      ASSERT_LE(sphere.radius, highest * 1.0001) << policy.name;  // rounded down, so that a sphere that fits its pixel still does
      ASSERT_GE(sphere.radius, lowest * (1.0 - 1.0 / 60.0)) << policy.name;
    }
  }
}

TEST(CpuMarcher, CancellingThrowsAndLeavesAMarcherThatWorks) {
  const glm::uvec3 dims(64, 64, 64);
  const MarcherPtr marcher = makeCpuMarcher(makeTestVolume(VoxelType::uint8, dims, blobs(dims, 1)), everywhere(0.001f));
  const Camera small = lookingFrom({80.0f, 30.0f, 45.0f}, {}, 40, 40);
  const SampleFrame before = marcher->march(small, {});
  std::stop_source stopped;
  stopped.request_stop();
  Image<glm::vec4> image;
  EXPECT_THROW(marcher->march(small, {}, stopped.get_token()), OperationCancelled);
  EXPECT_THROW(marcher->render(small, {}, image, stopped.get_token()), OperationCancelled);

  // In the middle of work that would take minutes.
  MarchSettings fine;
  fine.render.step = 1e-3f;
  const Camera large = lookingFrom({80.0f, 30.0f, 45.0f}, {}, 512, 512);
  std::stop_source source;
  std::jthread stopper([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(30));
    source.request_stop();
  });
  EXPECT_THROW(marcher->march(large, fine, source.get_token()), OperationCancelled);
  EXPECT_TRUE(sameFrame(marcher->march(small, {}), before));
}

TEST(CpuMarcher, AnotherTransferFunctionIsAMarcherMadeWithIt) {
  const glm::uvec3 dims(40, 30, 36);
  const Camera camera = lookingFrom({70.0f, 30.0f, 45.0f}, {}, 60, 50);
  for (const VoxelType type : kAllVoxelTypes) {
    SCOPED_TRACE(nameOf(type));
    const bool isFloat = type == VoxelType::float32 || type == VoxelType::float64;
    const FieldFunction field = blobs(dims, 5);
    const VolumePtr volume = makeTestVolume(
        type, dims, [&](const glm::ivec3& p) { return isFloat && p.x % 9 == 0 ? std::nan("") : field(p); });
    const MarcherPtr first = makeCpuMarcher(volume, band(30.0, 50.0, 0.4f));
    const SampleFrame before = first->march(camera, {});
    ASSERT_GT(before.size(), 100u);
    MarcherPtr marcher = first;
    for (const double from : {10.0, 55.0, 40.0}) {  // one from the other: origins of values come and go
      const TransferFunction function = band(from, from + 25.0, 0.2f);
      marcher = marcher->withTransferFunction(function);
      const MarcherPtr fresh = makeCpuMarcher(volume, function);
      EXPECT_TRUE(sameFrame(marcher->march(camera, {}), fresh->march(camera, {}))) << from;
      EXPECT_TRUE(sameBits(rendered(*marcher, camera), rendered(*fresh, camera))) << from;
      EXPECT_FALSE(sameBits(rendered(*marcher, camera), rendered(*first, camera))) << from;
      EXPECT_EQ(marcher->volume(), volume);
    }
    EXPECT_TRUE(sameFrame(first->march(camera, {}), before));
  }
}

TEST(CpuMarcher, AnotherTransferFunctionKeepsItsTurns) {
  const glm::uvec3 dims(64, 64, 64);
  const MarcherPtr whole = makeCpuMarcher(makeTestVolume(VoxelType::uint8, dims, blobs(dims, 1)), everywhere(0.5f));
  const MarcherPtr limited = whole->twin(std::make_shared<Turns>(
      TurnSettings{.slice = std::chrono::milliseconds(1), .limit = std::chrono::milliseconds(2)}));
  MarchSettings fine;
  fine.render.step = 1e-3f;
  const Camera large = lookingFrom({80.0f, 30.0f, 45.0f}, {}, 256, 256);
  EXPECT_THROW(limited->withTransferFunction(everywhere(0.001f))->march(large, fine), WorkLimitExceeded);
}

TEST(CpuMarcher, RefusesUnusableCamerasAndSettings) {
  const MarcherPtr marcher = makeCpuMarcher(constantVolume(VoxelType::uint8, {4, 4, 4}), everywhere(0.5f));
  const Camera good = lookingFrom({8.0f, 0.0f, 0.0f}, {}, 4, 4);
  Image<glm::vec4> image;
  Camera bad = good;
  bad.tanHalfFovY = std::nanf("");
  EXPECT_THROW(marcher->march(bad, {}), InputError);
  EXPECT_THROW(marcher->render(bad, {}, image), InputError);
  const float nan = std::nanf("");
  for (const MarchSettings& settings :
       {MarchSettings{.render = {.step = 0.0f}, .sample = {}}, MarchSettings{.render = {.step = nan}, .sample = {}}, MarchSettings{.render = {.contribution = 0.0f}, .sample = {}},
        MarchSettings{.render = {}, .sample = {.threshold = 2.0f}},
        MarchSettings{.render = {}, .sample = {.radiusScale = -1.0f}}, MarchSettings{.render = {}, .sample = {.samplesPerRay = 9}}})
    EXPECT_THROW(marcher->march(good, settings), UsageError);
  // Before memory is taken: the largest picture has room for four samples a ray.
  Camera large = good;
  large.width = large.height = 8192;
  try {
    marcher->march(large, {.render = {}, .sample = {.samplesPerRay = 8}});
    FAIL() << "6 GB were asked for";
  } catch (const UsageError& error) {
    EXPECT_STREQ(error.what(), "a picture of 8192x8192 pixels may have at most 4 samples a ray, not 8");
  }
  try {
    marcher->march(large, {.render = {}, .sample = {.segments = 5}});
    FAIL() << "more than a frame may have";
  } catch (const UsageError& error) {
    EXPECT_STREQ(error.what(), "a picture of 8192x8192 pixels may have at most 4 segments a ray, not 5");
  }
}

}  // namespace
}  // namespace warpscope
