// The CPU's marcher: what faint or non-finite voxels, extreme values, thin volumes and odd cameras may do to a picture.
// Mirrors render/march/marcher_cpu.h; closed forms in double.
#include "render/march/marcher_cpu.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <thread>

#include "marcher_cases.h"
#include "render/base/error.h"
#include "test_volumes.h"
#include "tests/frame_samples.h"

namespace warpscope {
namespace {

const double kNan = std::nan("");
const double kInfinity = std::numeric_limits<double>::infinity();

VolumePtr constantVolume(VoxelType type, const glm::uvec3& dims, double value = 50.0) {
  return makeTestVolume(type, dims, [=](const glm::ivec3&) { return value; });
}

double slab(double alpha, double length) { return -std::expm1(length * std::log1p(-alpha)); }

/// Every pixel shows a homogeneous body of `alpha` per unit that fills the volume's box.
void expectBody(const Image<glm::vec4>& image, const Camera& camera, const Box& box, double alpha, const std::string& label,
                double tolerance = 1e-6) {
  for (uint32_t y = 0; y < image.height(); ++y)
    for (uint32_t x = 0; x < image.width(); ++x)
      ASSERT_NEAR(image(x, y).a, slab(alpha, lengthInside(camera, x, y, box)), tolerance) << label << ", pixel " << x << " " << y;
}

TEST(CpuMarcher, AMillionNearlyTransparentSamples) {
  const VolumePtr volume = constantVolume(VoxelType::float32, {1000, 1, 1});
  MarchSettings settings;
  settings.render.step = 1e-3f;
  settings.render.skipEmpty = false;
  const Camera camera = lookingFrom({-501.0f, 0.0f, 0.0f}, {}, 1, 1, 1e-3f);
  const Image<glm::vec4> image = rendered(*makeCpuMarcher(volume, everywhere(1e-5f)), camera, settings);
  EXPECT_NEAR(image(0, 0).a, slab(1e-5, 1000.0), 1e-6);
}

TEST(CpuMarcher, HomogeneousBodyIsTheClosedFormAtEveryStep) {
  const VolumePtr volume = constantVolume(VoxelType::uint8, {20, 16, 12});
  const MarcherPtr marcher = makeCpuMarcher(volume, everywhere(0.05f));
  const Camera camera = lookingFrom({15.0f, 11.0f, 17.0f}, {}, 48, 40);
  MarchSettings settings;
  settings.render.terminateEarly = false;
  for (const float step : {1.0f, 0.5f, 0.25f, 0.3f}) {
    settings.render.step = step;
    expectBody(rendered(*marcher, camera, settings), camera, volume->bounds(), 0.05, "step " + std::to_string(step), 1.5e-6);
  }
}

TEST(CpuMarcher, StoppingEarlyChangesNoDepthAndHardlyAColour) {
  const glm::uvec3 dims(40, 36, 32);
  const MarcherPtr marcher = makeCpuMarcher(makeTestVolume(VoxelType::uint8, dims, blobs(dims, 35)),
                                            {{{5.0, {1.0f, 0.2f, 0.1f}, 0.0f}, {100.0, {0.1f, 0.5f, 1.0f}, 0.95f}}});
  const Camera camera = lookingFrom({50.0f, 30.0f, 45.0f}, {}, 64, 64);
  MarchSettings stop, go;
  go.render.terminateEarly = false;
  const Image<glm::vec4> a = rendered(*marcher, camera, stop), b = rendered(*marcher, camera, go);
  EXPECT_FALSE(sameBits(a, b));  // or the test would show nothing
  for (size_t i = 0; i < a.size(); ++i)
    for (int c = 0; c < 4; ++c) ASSERT_LE(std::abs(a[i][c] - b[i][c]), stop.render.contribution);
  for (const auto& entry : kHeuristics) {
    stop.sample.heuristic = go.sample.heuristic = entry.value;
    const SampleFrame x = marcher->march(camera, stop), y = marcher->march(camera, go);
    EXPECT_GT(x.size(), 500u);
    EXPECT_TRUE(x.samples == y.samples) << entry.name;
  }
}

// --- Voxels that are not finite.

/// Pixels whose rays come within a voxel of one of the places: what is there may show in them.
Image<uint8_t> pixelsNear(const std::vector<glm::ivec3>& places, const Camera& camera, const Box& bounds) {
  Image<uint8_t> near(camera.width, camera.height, 0);
  const glm::vec3 last = bounds.extent() - 1.0f;  // voxel coordinates of the last voxel; edges are 1
  for (uint32_t y = 0; y < camera.height; ++y)
    for (uint32_t x = 0; x < camera.width; ++x) {
      const Ray ray = pixelRay(camera, glm::vec2(x, y) + 0.5f);
      for (float t = 0.0f; t < 90.0f && !near(x, y); t += 0.05f) {
        const glm::vec3 coordinate = ray.at(t) - bounds.lower - 0.5f;
        if (glm::any(glm::lessThan(coordinate, glm::vec3(-0.6f))) || glm::any(glm::greaterThan(coordinate, last + 0.6f))) continue;
        const glm::vec3 clamped = glm::clamp(coordinate, glm::vec3(0.0f), last);
        for (const glm::ivec3& place : places) {
          const glm::vec3 apart = glm::abs(clamped - glm::vec3(place));
          if (apart.x < 1.1f && apart.y < 1.1f && apart.z < 1.1f) near(x, y) = 1;
        }
      }
    }
  return near;
}

TEST(CpuMarcher, NonFiniteVoxelsNeverSpread) {
  const glm::uvec3 dims(24, 22, 20);
  const FieldFunction field = blobs(dims, 40);
  const std::vector<glm::ivec3> places{{5, 6, 7}, {12, 11, 10}, {13, 11, 10}, {20, 3, 15}, {0, 0, 0}, {23, 21, 19}};
  const TransferFunction function{{{0.0, {1.0f, 0.2f, 0.1f}, 0.01f}, {100.0, {0.1f, 0.5f, 1.0f}, 0.3f}}};
  const Camera camera = lookingFrom({30.0f, 20.0f, 25.0f}, {}, 96, 96);
  MarchSettings settings;
  settings.render.terminateEarly = false;
  for (const VoxelType type : {VoxelType::float32, VoxelType::float64}) {
    const auto volumeWith = [&](double first, double second) {
      return makeTestVolume(type, dims, [&](const glm::ivec3& p) {
        const auto place = std::find(places.begin(), places.end(), p);
        if (place == places.end()) return field(p);
        return (place - places.begin()) % 2 ? second : first;
      });
    };
    const VolumePtr clean = volumeWith(50.0, 50.0);
    const Image<glm::vec4> expected = rendered(*makeCpuMarcher(clean, function), camera, settings);
    const Image<uint8_t> near = pixelsNear(places, camera, clean->bounds());
    for (const auto& [first, second] : {std::pair{kNan, kNan}, {kInfinity, -kInfinity}, {-kInfinity, kNan}}) {
      const VolumePtr holed = volumeWith(first, second);
      EXPECT_EQ(holed->statistics().nonFinite, places.size());
      ASSERT_EQ(holed->statistics().rangeUpper, clean->statistics().rangeUpper);
      const Image<glm::vec4> image = rendered(*makeCpuMarcher(holed, function), camera, settings);
      EXPECT_FALSE(std::isnan(largestAlpha(image)));
      size_t untouched = 0, changed = 0;
      for (uint32_t y = 0; y < camera.height; ++y)
        for (uint32_t x = 0; x < camera.width; ++x) {
          if (near(x, y)) {
            changed += image(x, y) != expected(x, y);
            continue;
          }
          ++untouched;
          ASSERT_EQ(image(x, y), expected(x, y)) << nameOf(type) << ", pixel " << x << " " << y;
        }
      EXPECT_GT(untouched, 3000u);
      EXPECT_GT(changed, 50u);
    }
  }
}

TEST(CpuMarcher, NonFiniteVoxelsAreShownAsNothing) {
  const Camera camera = lookingFrom({0.0f, 0.0f, 40.0f}, {}, 9, 9, 0.01f);
  for (const double hole : {kNan, kInfinity, -kInfinity}) {
    const MarcherPtr all = makeCpuMarcher(constantVolume(VoxelType::float32, {8, 8, 8}, hole), everywhere(0.5f));
    EXPECT_EQ(largestAlpha(rendered(*all, camera)), 0.0f);
    EXPECT_EQ(all->march(camera, {}).size(), 0u);
    // A layer of 6 of 20 voxels is missing: the body is shorter by 6.
    const VolumePtr layered = makeTestVolume(VoxelType::float64, {9, 9, 20}, [&](auto p) { return p.z >= 7 && p.z < 13 ? hole : 50.0; });
    MarchSettings settings;
    settings.render.step = 0.01f;
    EXPECT_NEAR(rendered(*makeCpuMarcher(layered, everywhere(0.05f)), camera, settings)(4, 4).a, slab(0.05, 14.0), 1e-3);
  }
}

// --- Values.

TEST(CpuMarcher, TheGreatest16BitValueIsTheTablesLastEntry) {
  const VolumePtr volume = makeTestVolume(VoxelType::uint16, {8, 8, 8}, [](auto p) { return p.x < 4 ? 0.0 : 65535.0; });
  const TransferFunction top{{{65530.0, glm::vec3(1.0f), 0.0f}, {65530.0, glm::vec3(0.0f, 1.0f, 0.0f), 1.0f}}};
  const Camera camera = lookingFrom({2.5f, 0.0f, 40.0f}, {2.5f, 0.0f, 0.0f}, 3, 3, 0.01f);
  EXPECT_EQ(rendered(*makeCpuMarcher(volume, top), camera)(1, 1), glm::vec4(0.0f, 1.0f, 0.0f, 1.0f));
}

TEST(CpuMarcher, ConstantVolumesShowTheirOneValue) {
  for (const VoxelType type : kAllVoxelTypes) {
    const VolumePtr volume = constantVolume(type, {6, 5, 4}, 7.0);
    const Camera camera = lookingFrom({9.0f, 6.0f, 8.0f}, {}, 24, 24);
    // A step exactly at the value; of bytes, whose table spans 0..255, just below it.
    const double at = type == VoxelType::uint8 ? 6.9 : 7.0;
    const MarcherPtr marcher = makeCpuMarcher(volume, {{{at, glm::vec3(1.0f), 0.0f}, {at, glm::vec3(1.0f), 0.125f}}});
    expectBody(rendered(*marcher, camera), camera, volume->bounds(), 0.125, std::string(nameOf(type)));
  }
}

TEST(CpuMarcher, ThinVolumes) {
  for (const VoxelType type : kAllVoxelTypes)
    for (const glm::uvec3 dims : {glm::uvec3(1), glm::uvec3(20, 1, 1), glm::uvec3(1, 20, 1), glm::uvec3(1, 1, 20), glm::uvec3(1, 20, 20),
                                  glm::uvec3(20, 1, 20), glm::uvec3(20, 20, 1), glm::uvec3(2, 1, 3)}) {
      const VolumePtr volume = constantVolume(type, dims);
      const std::string label = std::string(nameOf(type)) + " " + std::to_string(dims.x) + "x" + std::to_string(dims.y) + "x" + std::to_string(dims.z);
      const Camera camera = lookingFrom({14.0f, 8.0f, 12.0f}, {}, 32, 32, 0.7f);
      MarchSettings settings;
      settings.render.terminateEarly = false;
      expectBody(rendered(*makeCpuMarcher(volume, everywhere(0.2f)), camera, settings), camera, volume->bounds(), 0.2, label, 3e-6);
      EXPECT_GT(makeCpuMarcher(volume, everywhere(0.9f))->march(camera, settings).size(), 0u) << label;
    }
}

// --- Cameras.

TEST(CpuMarcher, CamerasAnywhere) {
  const VolumePtr volume = constantVolume(VoxelType::uint8, {16, 12, 10});
  const MarcherPtr marcher = makeCpuMarcher(volume, everywhere(0.04f));
  const Box& box = volume->bounds();
  MarchSettings settings;
  settings.render.terminateEarly = false;
  const auto check = [&](const glm::vec3& eye, const glm::vec3& at, const std::string& label) {
    const Camera camera = lookingFrom(eye, at, 31, 31);
    expectBody(rendered(*marcher, camera, settings), camera, box, 0.04, label, 2e-6);
    for (const auto& entry : kHeuristics) {
      MarchSettings deep = settings;
      deep.sample.heuristic = entry.value;
      const SampleFrame frame = marcher->march(camera, deep);
      for (size_t i = 0; i < frame.size(); ++i) {
        const glm::vec3 center = sphereOf(frame, i).center;
        ASSERT_TRUE(glm::all(glm::greaterThanEqual(center, box.lower)) && glm::all(glm::lessThanEqual(center, box.upper))) << label;
      }
    }
  };
  check({0.0f, 0.0f, 0.0f}, {0.3f, 0.2f, -1.0f}, "inside");
  check({7.9f, -5.9f, 4.9f}, {0.0f, 0.0f, 0.0f}, "inside, in a corner");
  check({0.0f, 0.0f, 5.0f}, {0.1f, 0.2f, 0.0f}, "on a face, looking in");
  check({0.0f, 0.0f, 5.0f}, {0.1f, 0.2f, 9.0f}, "on a face, looking out");
  for (int axis = 0; axis < 3; ++axis)
    for (const float sign : {-1.0f, 1.0f}) {
      glm::vec3 eye(0.0f);
      eye[axis] = 30.0f * sign;
      check(eye, {}, "along an axis");
      check({}, eye, "from the centre along an axis");
    }
  const Camera away = lookingFrom({0.0f, 3.0f, 20.0f}, {0.0f, 3.0f, 40.0f}, 31, 31);
  EXPECT_EQ(largestAlpha(rendered(*marcher, away, settings)), 0.0f);
  EXPECT_EQ(marcher->march(away, settings).size(), 0u);
}

TEST(CpuMarcher, AnEyeInAnOpaqueBodySeesItEverywhere) {
  // Depths near 0 are depths: no pixel is lost. And the frame of a full picture is full.
  const VolumePtr volume = constantVolume(VoxelType::uint8, {16, 16, 16});
  const MarcherPtr marcher = makeCpuMarcher(volume, everywhere(1.0f));
  const Camera camera = lookingFrom({1.0f, 2.0f, 3.0f}, {}, 40, 30);
  for (const auto& entry : kHeuristics) {
    MarchSettings settings;
    settings.sample.heuristic = entry.value;
    const SampleFrame frame = marcher->march(camera, settings);
    ASSERT_EQ(frame.size(), 1200u) << entry.name;
    for (size_t i = 0; i < frame.size(); ++i) {
      ASSERT_LE(glm::length(sphereOf(frame, i).center - camera.eye), settings.render.step + 1e-3f) << entry.name;
      ASSERT_EQ(frame.colors[i], 0xffffffffu);
    }
  }
}

TEST(CpuMarcher, DepthsAreFinerThan8Bits) {
  // A slanted plane of opaque matter: neighbouring pixels' depths differ by much less than 1/256 of the range, and all are told apart.
  const VolumePtr volume = makeTestVolume(VoxelType::float32, {64, 8, 64}, [](auto p) { return 1.0 - p.z + 0.05 * p.x; });
  const MarcherPtr marcher = makeCpuMarcher(volume, {{{-31.0, glm::vec3(1.0f), 0.0f}, {-31.0, glm::vec3(1.0f), 1.0f}}});
  const Camera camera = lookingFrom({0.0f, 0.0f, 1000.0f}, {}, 64, 1, 0.01f / 64.0f * 2.0f);
  MarchSettings settings;
  settings.sample.heuristic = Heuristic::entrance;
  settings.render.step = 1e-3f;
  const SampleFrame frame = marcher->march(camera, settings);
  ASSERT_EQ(frame.size(), 64u);
  for (size_t i = 1; i < frame.size(); ++i) ASSERT_NE(sphereOf(frame, i).center.z, sphereOf(frame, i - 1).center.z);
}

// --- The interface's promises.

TEST(CpuMarcher, SameFrameWhateverTheNumberOfThreads) {
  const glm::uvec3 dims(40, 36, 32);
  const MarcherPtr marcher = makeCpuMarcher(makeTestVolume(VoxelType::uint16, dims, blobs(dims, 53)),
                                            {{{5.0, {1.0f, 0.2f, 0.1f}, 0.0f}, {100.0, {0.1f, 0.5f, 1.0f}, 0.6f}}});
  const Camera camera = lookingFrom({50.0f, 30.0f, 45.0f}, {}, 130, 97);
  const SampleFrame parallel = marcher->march(camera, {});
  const Image<glm::vec4> image = rendered(*marcher, camera);
  for (const size_t threads : {1, 2, 7}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    EXPECT_TRUE(sameFrame(marcher->march(camera, {}), parallel)) << threads;
    EXPECT_TRUE(sameBits(rendered(*marcher, camera), image)) << threads;
  }
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
  // Before memory is taken: the largest picture has room for one sample a ray.
  Camera large = good;
  large.width = large.height = kMaxImageSide;
  try {
    marcher->march(large, {.render = {}, .sample = {.samplesPerRay = 8}});
    FAIL() << "26 GB were asked for";
  } catch (const UsageError& error) {
    EXPECT_STREQ(error.what(), "a picture of 16384x16384 pixels may have at most 1 samples a ray, not 8");
  }
}

}  // namespace
}  // namespace warpscope
