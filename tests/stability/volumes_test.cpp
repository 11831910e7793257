// Through volumes: cases 26, 30, 33, 35, 39 to 42, 44 to 46, 53 and 62. Truth: closed forms in double; itself, without
// what may change nothing. Mirrors render/march/marcher.h and empty_space.h. One ray: marching_test.cpp.
#include "render/march/empty_space.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>

#include "app/scene/scene.h"
#include "render/base/error.h"
#include "tests/frame_samples.h"
#include "tests/marcher_cases.h"
#include "tests/stability/backends.h"
#include "tests/stability/record.h"
#include "tests/test_volumes.h"

namespace warpscope {
namespace {

const double kNan = std::nan("");
const double kInfinity = std::numeric_limits<double>::infinity();

VolumePtr constantVolume(VoxelType type, const glm::uvec3& dims, double value = 50.0) {
  return makeTestVolume(type, dims, [=](const glm::ivec3&) { return value; });
}

double slab(double alpha, double length) { return -std::expm1(length * std::log1p(-alpha)); }

/// Every pixel shows a homogeneous body of `alpha` per unit that fills the volume's box.
void expectBody(const Image<glm::vec4>& image, const Camera& camera, const Box& box, double alpha,
                const std::string& label, double tolerance, Worst& worst) {
  for (uint32_t y = 0; y < image.height(); ++y)
    for (uint32_t x = 0; x < image.width(); ++x) {
      const double error = std::abs(static_cast<double>(image(x, y).a) - slab(alpha, lengthInside(camera, x, y, box)));
      ASSERT_LE(error, tolerance) << label << ", pixel " << x << " " << y;
      worst.see(error);
    }
}

TEST_P(Case30, ThroughAVolume) {
  const VolumePtr volume = constantVolume(VoxelType::float32, {1000, 1, 1});
  MarchSettings settings;
  settings.render.step = 1e-3f;
  settings.render.skipEmpty = false;
  const Camera camera = lookingFrom({-501.0f, 0.0f, 0.0f}, {}, 1, 1, 1e-3f);
  const Image<glm::vec4> image = rendered(*marcherOn(GetParam(), volume, everywhere(1e-5f)), camera, settings);
  record({"march of 1e6 samples of 1e-8", "closed form in double", "of opacity",
          std::abs(static_cast<double>(image(0, 0).a) - slab(1e-5, 1000.0)), 1e-6, GetParam()});
}

TEST_P(Case33, HomogeneousBodyIsTheClosedFormAtEveryStep) {
  const VolumePtr volume = constantVolume(VoxelType::uint8, {20, 16, 12});
  const MarcherPtr marcher = marcherOn(GetParam(), volume, everywhere(0.05f));
  const Camera camera = lookingFrom({15.0f, 11.0f, 17.0f}, {}, 48, 40);
  Worst worst;
  MarchSettings settings;
  settings.render.terminateEarly = false;
  for (const float step : {1.0f, 0.5f, 0.25f, 0.3f}) {
    settings.render.step = step;
    expectBody(rendered(*marcher, camera, settings), camera, volume->bounds(), 0.05, "step " + std::to_string(step),
               1.5e-6, worst);
  }
  record({"march of a homogeneous body", "closed form in double", "of opacity", worst.value(), 1.5e-6, GetParam()});
}

TEST_P(Case35, StoppingEarlyChangesNoDepthAndHardlyAColour) {
  const glm::uvec3 dims(40, 36, 32);
  const MarcherPtr marcher = marcherOn(GetParam(), makeTestVolume(VoxelType::uint8, dims, blobs(dims, 35)),
                                       {{{5.0, {1.0f, 0.2f, 0.1f}, 0.0f}, {100.0, {0.1f, 0.5f, 1.0f}, 0.95f}}});
  const Camera camera = lookingFrom({50.0f, 30.0f, 45.0f}, {}, 64, 64);
  MarchSettings stop, go;
  go.render.terminateEarly = false;
  const Image<glm::vec4> a = rendered(*marcher, camera, stop), b = rendered(*marcher, camera, go);
  EXPECT_FALSE(sameBits(a, b));  // or the test would show nothing
  Worst worst;
  for (size_t i = 0; i < a.size(); ++i)
    for (int c = 0; c < 4; ++c) worst.see(static_cast<double>(std::abs(a[i][c] - b[i][c]) / stop.render.contribution));
  for (const auto& entry : kHeuristics) {
    stop.sample.heuristic = go.sample.heuristic = entry.value;
    const SampleFrame x = marcher->march(camera, stop), y = marcher->march(camera, go);
    EXPECT_GT(x.size(), 500u);
    EXPECT_TRUE(x.samples == y.samples) << entry.name;
  }
  record({"march ended early: the same depths, and colours", "itself, to the end", "of the threshold", worst.value(),
          1.0, GetParam()});
}

TEST_P(Case26, DepthsAreFinerThan8Bits) {
  // A slanted plane of opaque matter: neighbouring pixels' depths differ by much less than 1/256 of the range, and all
  // are told apart.
  const VolumePtr volume =
      makeTestVolume(VoxelType::float32, {64, 8, 64}, [](auto p) { return 1.0 - p.z + 0.05 * p.x; });
  const MarcherPtr marcher =
      marcherOn(GetParam(), volume, {{{-31.0, glm::vec3(1.0f), 0.0f}, {-31.0, glm::vec3(1.0f), 1.0f}}});
  const Camera camera = lookingFrom({0.0f, 0.0f, 1000.0f}, {}, 64, 1, 0.01f / 64.0f * 2.0f);
  MarchSettings settings;
  settings.sample.heuristic = Heuristic::entrance;
  settings.render.step = 1e-3f;
  const SampleFrame frame = marcher->march(camera, settings);
  ASSERT_EQ(frame.size(), 64u);
  for (size_t i = 1; i < frame.size(); ++i) ASSERT_NE(sphereOf(frame, i).center.z, sphereOf(frame, i - 1).center.z);
  recordExact("depths of a slanted plane are all told apart", "definition", GetParam());
}

TEST_P(Case38, OfAConstantVolumeTheSteepestRiseIsItsEntrance) {
  const MarcherPtr marcher = marcherOn(GetParam(), constantVolume(VoxelType::float32, {12, 10, 8}), everywhere(0.3f));
  const Camera camera = lookingFrom({20.0f, 14.0f, 17.0f}, {}, 48, 40);
  MarchSettings settings;
  settings.sample.heuristic = Heuristic::entrance;
  const SampleFrame entrance = marcher->march(camera, settings);
  settings.sample.heuristic = Heuristic::gradient;
  const SampleFrame gradient = marcher->march(camera, settings);
  EXPECT_GT(entrance.size(), 400u);
  EXPECT_TRUE(entrance.samples == gradient.samples);
  recordExact("heuristic gradient of a constant volume", "heuristic entrance", GetParam());
}

TEST_P(Case39, BeyondTheOutermostCentresValuesAreTheBorders) {
  // Matter in the outermost layer alone, from its value on: the half of each voxel that lies beyond its centre, and no
  // more.
  Worst worst;
  for (const int axis : {0, 1, 2})
    for (const bool isUpper : {false, true}) {
      const VolumePtr volume = makeTestVolume(VoxelType::uint8, glm::uvec3(8), [&](const glm::ivec3& p) {
        return p[axis] == (isUpper ? 7 : 0) ? 50.0 : 0.0;
      });
      MarchSettings settings;
      settings.render.step = 0.01f;
      settings.render.contribution = 1e-6f;
      glm::vec3 eye(0.25f);
      eye[axis] = isUpper ? 30.0f : -30.0f;
      glm::vec3 at(0.25f);
      at[axis] = 0.0f;
      const MarcherPtr marcher =
          marcherOn(GetParam(), volume, {{{50.0, glm::vec3(1.0f), 0.0f}, {50.0, glm::vec3(1.0f), 0.5f}}});
      worst.see(std::abs(static_cast<double>(rendered(*marcher, lookingFrom(eye, at, 1, 1), settings)(0, 0).a) -
                         slab(0.5, 0.5)));
    }
  record({"march of the outermost layer, step .01", "closed form in double", "of opacity: a step's", worst.value(),
          0.0075, GetParam()});
}

/// Pixels whose rays come within a voxel of one of the places: what is there may show in them.
Image<uint8_t> pixelsNear(const std::vector<glm::ivec3>& places, const Camera& camera, const Box& bounds) {
  Image<uint8_t> near(camera.width, camera.height, 0);
  const glm::vec3 last = bounds.extent() - 1.0f;  // voxel coordinates of the last voxel; edges are 1
  for (uint32_t y = 0; y < camera.height; ++y)
    for (uint32_t x = 0; x < camera.width; ++x) {
      const Ray ray = pixelRay(camera, glm::vec2(x, y) + 0.5f);
      for (float t = 0.0f; t < 90.0f && !near(x, y); t += 0.05f) {
        const glm::vec3 coordinate = ray.at(t) - bounds.lower - 0.5f;
        if (glm::any(glm::lessThan(coordinate, glm::vec3(-0.6f))) ||
            glm::any(glm::greaterThan(coordinate, last + 0.6f)))
          continue;
        const glm::vec3 clamped = glm::clamp(coordinate, glm::vec3(0.0f), last);
        for (const glm::ivec3& place : places) {
          const glm::vec3 apart = glm::abs(clamped - glm::vec3(place));
          if (apart.x < 1.1f && apart.y < 1.1f && apart.z < 1.1f) near(x, y) = 1;
        }
      }
    }
  return near;
}

TEST_P(Case40, NonFiniteVoxelsNeverSpread) {
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
    const Image<glm::vec4> expected = rendered(*marcherOn(GetParam(), clean, function), camera, settings);
    const Image<uint8_t> near = pixelsNear(places, camera, clean->bounds());
    for (const auto& [first, second] : {std::pair{kNan, kNan}, {kInfinity, -kInfinity}, {-kInfinity, kNan}}) {
      const VolumePtr holed = volumeWith(first, second);
      EXPECT_EQ(holed->statistics().nonFinite, places.size());
      ASSERT_EQ(holed->statistics().rangeUpper, clean->statistics().rangeUpper);
      const Image<glm::vec4> image = rendered(*marcherOn(GetParam(), holed, function), camera, settings);
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
  recordExact("march beside NaN and infinite voxels", "the volume without them", GetParam());
}

TEST_P(Case40, NonFiniteVoxelsAreShownAsNothing) {
  const Camera camera = lookingFrom({0.0f, 0.0f, 40.0f}, {}, 9, 9, 0.01f);
  Worst worst;
  for (const double hole : {kNan, kInfinity, -kInfinity}) {
    const MarcherPtr all = marcherOn(GetParam(), constantVolume(VoxelType::float32, {8, 8, 8}, hole), everywhere(0.5f));
    EXPECT_EQ(largestAlpha(rendered(*all, camera)), 0.0f);
    EXPECT_EQ(all->march(camera, {}).size(), 0u);
    // A layer of 6 of 20 voxels is missing: the body is shorter by 6.
    const VolumePtr layered =
        makeTestVolume(VoxelType::float64, {9, 9, 20}, [&](auto p) { return p.z >= 7 && p.z < 13 ? hole : 50.0; });
    MarchSettings settings;
    settings.render.step = 0.01f;
    worst.see(std::abs(
        static_cast<double>(rendered(*marcherOn(GetParam(), layered, everywhere(0.05f)), camera, settings)(4, 4).a) -
        slab(0.05, 14.0)));
  }
  record({"march through a layer that is missing", "closed form in double", "of opacity", worst.value(), 1e-3,
          GetParam()});
}

TEST_P(Case41, TheGreatest16BitValueIsTheTablesLastEntry) {
  const VolumePtr volume = makeTestVolume(VoxelType::uint16, {8, 8, 8}, [](auto p) { return p.x < 4 ? 0.0 : 65535.0; });
  const TransferFunction top{{{65530.0, glm::vec3(1.0f), 0.0f}, {65530.0, glm::vec3(0.0f, 1.0f, 0.0f), 1.0f}}};
  const Camera camera = lookingFrom({2.5f, 0.0f, 40.0f}, {2.5f, 0.0f, 0.0f}, 3, 3, 0.01f);
  EXPECT_EQ(rendered(*marcherOn(GetParam(), volume, top), camera)(1, 1), glm::vec4(0.0f, 1.0f, 0.0f, 1.0f));
  recordExact("march of 65535 in uint16", "definition", GetParam());
}

TEST_P(Case42, ConstantVolumesShowTheirOneValue) {
  Worst worst;
  for (const VoxelType type : kAllVoxelTypes) {
    const VolumePtr volume = constantVolume(type, {6, 5, 4}, 7.0);
    const Camera camera = lookingFrom({9.0f, 6.0f, 8.0f}, {}, 24, 24);
    // A step exactly at the value; of bytes, whose table spans 0..255, just below it.
    const double at = type == VoxelType::uint8 ? 6.9 : 7.0;
    const MarcherPtr marcher =
        marcherOn(GetParam(), volume, {{{at, glm::vec3(1.0f), 0.0f}, {at, glm::vec3(1.0f), 0.125f}}});
    expectBody(rendered(*marcher, camera), camera, volume->bounds(), 0.125, std::string(nameOf(type)), 1e-6, worst);
  }
  record({"march of constant volumes of every type", "closed form in double", "of opacity", worst.value(), 1e-6,
          GetParam()});
}

TEST_P(Case44, ThinVolumes) {
  Worst worst;
  for (const VoxelType type : kAllVoxelTypes)
    for (const glm::uvec3 dims :
         {glm::uvec3(1), glm::uvec3(20, 1, 1), glm::uvec3(1, 20, 1), glm::uvec3(1, 1, 20), glm::uvec3(1, 20, 20),
          glm::uvec3(20, 1, 20), glm::uvec3(20, 20, 1), glm::uvec3(2, 1, 3)}) {
      const VolumePtr volume = constantVolume(type, dims);
      const std::string label = std::string(nameOf(type)) + " " + std::to_string(dims.x) + "x" +
                                std::to_string(dims.y) + "x" + std::to_string(dims.z);
      const Camera camera = lookingFrom({14.0f, 8.0f, 12.0f}, {}, 32, 32, 0.7f);
      MarchSettings settings;
      settings.render.terminateEarly = false;
      expectBody(rendered(*marcherOn(GetParam(), volume, everywhere(0.2f)), camera, settings), camera, volume->bounds(),
                 0.2, label, 3e-6, worst);
      EXPECT_GT(marcherOn(GetParam(), volume, everywhere(0.9f))->march(camera, settings).size(), 0u) << label;
    }
  record({"march of volumes one voxel thick, of every type", "closed form in double", "of opacity", worst.value(), 3e-6,
          GetParam()});
}

TEST_P(Case45, CamerasAnywhere) {
  const VolumePtr volume = constantVolume(VoxelType::uint8, {16, 12, 10});
  const MarcherPtr marcher = marcherOn(GetParam(), volume, everywhere(0.04f));
  const Box& box = volume->bounds();
  Worst worst;
  MarchSettings settings;
  settings.render.terminateEarly = false;
  const auto check = [&](const glm::vec3& eye, const glm::vec3& at, const std::string& label) {
    const Camera camera = lookingFrom(eye, at, 31, 31);
    expectBody(rendered(*marcher, camera, settings), camera, box, 0.04, label, 2e-6, worst);
    for (const auto& entry : kHeuristics) {
      MarchSettings deep = settings;
      deep.sample.heuristic = entry.value;
      const SampleFrame frame = marcher->march(camera, deep);
      for (size_t i = 0; i < frame.size(); ++i) {
        const glm::vec3 center = sphereOf(frame, i).center;
        ASSERT_TRUE(glm::all(glm::greaterThanEqual(center, box.lower)) &&
                    glm::all(glm::lessThanEqual(center, box.upper)))
            << label;
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
  record({"march from inside, on a face, along an axis, looking away", "closed form in double", "of opacity",
          worst.value(), 2e-6, GetParam()});
}

TEST_P(Case46, UnitAndPlaceOfTheWorldChangeNothing) {
  const glm::uvec3 dims(24, 20, 6);
  const auto sceneOf = [&](const glm::dvec3& spacing, const glm::dvec3& origin) {
    VolumeGeometry geometry;
    geometry.dims = dims;
    geometry.spacing = spacing;
    geometry.origin = origin;
    Scene scene;
    scene.volume = makeTestVolume(VoxelType::uint8, geometry, blobs(dims, 46));
    scene.transferFunction = {{{0.0, {1.0f, 0.3f, 0.1f}, 0.0f}, {100.0, {0.1f, 0.6f, 1.0f}, 0.4f}}};
    return scene;
  };
  for (const glm::dvec3 spacing : {glm::dvec3(1.0), glm::dvec3(1.0, 1.0, 100.0), glm::dvec3(2.0, 3.0, 1.0)}) {
    const Scene plain = sceneOf(spacing, glm::dvec3(0.0));
    const MarcherPtr plainMarcher = marcherOn(GetParam(), plain.volume, plain.transferFunction);
    for (const double unit : {1e-9, 0x1p-30, 0.1, 1e6})
      for (const glm::dvec3 origin : {glm::dvec3(0.0), glm::dvec3(1e7, -1e7, 1e7)}) {
        const Scene other = sceneOf(spacing * unit, origin);
        ASSERT_EQ(other.volume->bounds(), plain.volume->bounds()) << unit;
        for (const View& view : defaultViews()) {
          const Camera camera = makeCamera(other, view, 40, 32);
          ASSERT_EQ(camera, makeCamera(plain, view, 40, 32)) << unit;
          if (view.angleDeg != 30.0) continue;
          const MarcherPtr marcher = marcherOn(GetParam(), other.volume, other.transferFunction);
          const Image<glm::vec4> image = rendered(*marcher, camera);
          ASSERT_GT(largestAlpha(image), 0.3f);
          ASSERT_TRUE(sameBits(image, rendered(*plainMarcher, camera))) << unit;
          ASSERT_TRUE(sameFrame(marcher->march(camera, {}), plainMarcher->march(camera, {}))) << unit;
        }
      }
  }
  recordExact("cameras, pictures, frames of voxels 1:1:100, of 1e-9, at 1e7 mm", "the volume of unit voxels",
              GetParam());
}

TEST_P(Case53, SameFrameWhateverTheNumberOfThreads) {
  const glm::uvec3 dims(40, 36, 32);
  const MarcherPtr marcher = marcherOn(GetParam(), makeTestVolume(VoxelType::uint16, dims, blobs(dims, 53)),
                                       {{{5.0, {1.0f, 0.2f, 0.1f}, 0.0f}, {100.0, {0.1f, 0.5f, 1.0f}, 0.6f}}});
  const Camera camera = lookingFrom({50.0f, 30.0f, 45.0f}, {}, 130, 97);
  const SampleFrame parallel = marcher->march(camera, {});
  const Image<glm::vec4> image = rendered(*marcher, camera);
  for (const size_t threads : {1, 2, 7}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    EXPECT_TRUE(sameFrame(marcher->march(camera, {}), parallel)) << threads;
    EXPECT_TRUE(sameBits(rendered(*marcher, camera), image)) << threads;
  }
  recordExact("march by 1, 2 and 7 threads", "itself", GetParam());
}

TEST_P(Case62, AnEyeInAnOpaqueBodySeesItEverywhere) {
  // Depths near 0 are depths: no pixel is lost. And the frame of a full picture is full.
  const VolumePtr volume = constantVolume(VoxelType::uint8, {16, 16, 16});
  const MarcherPtr marcher = marcherOn(GetParam(), volume, everywhere(1.0f));
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
  recordExact("march from inside opaque matter covers every pixel", "definition", GetParam());
}

}  // namespace
}  // namespace warpscope
