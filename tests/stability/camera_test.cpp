// Cameras: cases 48 to 50, 62 and 63. Truth: 100 decimal digits of the given view, closed forms in double.
// Mirrors makeCamera of app/scene/scene.h, render/core/camera.h and pixel_grid.h. Rays and projections:
// projections_test.cpp.
#include "render/core/camera.h"

#include <gtest/gtest.h>

#include <boost/math/constants/constants.hpp>
#include <cmath>
#include <limits>

#include "app/scene/scene.h"
#include "render/base/error.h"
#include "render/core/image.h"
#include "render/march/own_picture.h"
#include "render/volume/procedural.h"
#include "render/warp/warp.h"
#include "tests/frame_samples.h"
#include "tests/marcher_cases.h"
#include "tests/stability/backends.h"
#include "tests/stability/device_probe.h"
#include "tests/stability/exact.h"
#include "tests/stability/magnitudes.h"
#include "tests/stability/probes.h"
#include "tests/stability/record.h"
#include "tests/test_volumes.h"

namespace warpscope {
namespace {

constexpr double kDisplayCode = 1.0 / 255.0;

/// A slab of one value, `thickness` voxels along z.
VolumePtr slab(uint32_t thickness) {
  return makeTestVolume(VoxelType::uint8, {64, 64, thickness}, [](const glm::ivec3&) { return 50.0; });
}

/// Largest difference of a picture's opacities from those of as much matter as the rays have in the box.
double largestError(const Image<glm::vec4>& image, const Camera& camera, const Box& box, double alpha) {
  double largest = 0.0;
  for (uint32_t y = 0; y < camera.height; ++y)
    for (uint32_t x = 0; x < camera.width; ++x) {
      const double expected = -std::expm1(lengthInside(camera, x, y, box) * std::log1p(-alpha));
      largest = std::max(largest, std::abs(static_cast<double>(image(x, y).a) - expected));
    }
  return largest;
}

TEST_P(Case63, AThinSlabsOpacityDoesNotDependOnTheCamerasDistance) {
  Worst worst;
  constexpr float kSize = 64.0f;
  for (const uint32_t thickness : {1u, 2u, 3u})
    for (const float alpha : {0.01f, 0.3f, 0.9f}) {
      const VolumePtr volume = slab(thickness);
      const MarcherPtr marcher = marcherOn(GetParam(), volume, everywhere(alpha));
      MarchSettings settings;
      settings.render.terminateEarly = false;
      settings.render.contribution = 1e-6f;
      for (const float sizes : {1e3f, 1e4f, 1e5f, 1e6f, 4e6f}) {
        const float distance = sizes * kSize;
        const Camera camera = lookingFrom({0.0f, 0.0f, distance}, {}, 24, 24, 0.4f / sizes);
        const Image<glm::vec4> image = rendered(*marcher, camera, settings);
        worst.see(largestError(image, camera, volume->bounds(), static_cast<double>(alpha)));
        EXPECT_GT(largestAlpha(image), 0.9f * alpha);
      }
    }
  record({"march of a thin slab from 1e3 to 4e6 sizes away", "closed form in double", "of opacity", worst.value(), 1e-5,
          GetParam()});
}

TEST_P(Case63, ASlabSeenAslantHasItsOpacityFromAnyDistance) {
  const VolumePtr volume = slab(4);
  const MarcherPtr marcher = marcherOn(GetParam(), volume, everywhere(0.2f));
  Worst worst;
  MarchSettings settings;
  settings.render.terminateEarly = false;
  settings.render.contribution = 1e-6f;
  for (const float sizes : {2.0f, 1e3f, 1e5f, 4e6f})
    for (const glm::vec3& from :
         {glm::vec3(0.6f, 0.0f, 0.8f), glm::vec3(-0.3f, 0.5f, 0.7f), glm::vec3(0.1f, -0.2f, -1.0f)}) {
      const Camera camera = lookingFrom(64.0f * sizes * glm::normalize(from), {}, 24, 24, 0.4f / sizes);
      // The eye is where single precision puts it, and so is what it sees: compared is the same camera, in double.
      const Image<glm::vec4> image = rendered(*marcher, camera, settings);
      worst.see(largestError(image, camera, volume->bounds(), 0.2));
      EXPECT_GT(largestAlpha(image), 0.0f) << sizes;
    }
  record({"march of a slab seen aslant from up to 4e6 sizes away", "closed form in double", "codes of 8 bits",
          worst.value() / kDisplayCode, 1.0, GetParam()});
}

TEST_P(Case63, SamplesSeenFromFarAwayLieWhereTheyAre) {
  // An opaque slab's front: half a step behind its face, wherever the camera is.
  const VolumePtr volume = slab(4);
  const MarcherPtr marcher = marcherOn(GetParam(), volume, everywhere(1.0f));
  MarchSettings settings;
  settings.sample.heuristic = Heuristic::entrance;
  for (const float sizes : {1.0f, 1e3f, 1e5f, 4e6f}) {
    const Camera camera = lookingFrom({0.0f, 0.0f, 64.0f * sizes}, {}, 32, 32, 0.4f / sizes);
    const SampleFrame frame = marcher->march(camera, settings);
    ASSERT_GT(frame.size(), 500u) << sizes;
    for (size_t i = 0; i < frame.size(); ++i) {
      const glm::vec3 center = sphereOf(frame, i).center;
      const float cosine = frame.grid().pixels.ray(columnOf(frame.samples[i]), rowOf(frame.samples[i])).cosine;
      ASSERT_NEAR(center.z, 2.0f - 0.5f * settings.render.step * cosine, 0.5f * frame.quantization.depthStep + 2e-5f)
          << sizes;
    }
  }
  recordExact("samples of a slab's front from up to 4e6 sizes away: half a step of depth, and 2e-5",
              "closed form in double", GetParam());
}

// --- Looking anywhere

Scene blobScene() {
  const glm::uvec3 dims(24, 20, 6);
  Scene scene;
  scene.volume = makeTestVolume(VoxelType::uint8, dims, blobs(dims, 46));
  scene.transferFunction = {{{0.0, {1.0f, 0.3f, 0.1f}, 0.0f}, {100.0, {0.1f, 0.6f, 1.0f}, 0.4f}}};
  return scene;
}

TEST(Case48, UpParallelToTheViewIsAViewLikeAnyOther) {
  const Scene scene = blobScene();
  const MarcherPtr marcher = makeCpuMarcher(scene.volume, scene.transferFunction);
  for (const double elevation : {90.0, -90.0})
    for (const double angle : {0.0, 30.0, -170.0}) {
      const Camera pole = makeCamera(scene, {angle, elevation, 1.0, {}}, 64, 64);
      EXPECT_TRUE(isUsable(pole));
      EXPECT_NEAR(std::abs(pole.forward.y), 1.0f, 1e-6f);  // straight down, or up
      // No jump on the way there.
      const Camera nearly = makeCamera(scene, {angle, elevation * (1.0 - 1e-6), 1.0, {}}, 64, 64);
      EXPECT_LT(glm::length(pole.right - nearly.right), 1e-4f);
      EXPECT_LT(glm::length(pole.up - nearly.up), 1e-4f);
      EXPECT_LT(glm::length(pole.eye - nearly.eye), 1e-2f);
      EXPECT_GT(largestAlpha(rendered(*marcher, pole)), 0.1f);
    }
  recordExact("makeCamera, up parallel to the view", "definition");
}

TEST(Case48, PropertyCamerasAreRoundedOnce) {
  // As scene.h says: a rounding of what double leaves, from up to 2^22 units away.
  constexpr double kInDouble = 4e-15, kFarthest = 0x1p22;
  const Scene scene = blobScene();
  Worst worst;
  checkProperty([&] {
    const View view{*anyInteger(-360, 360) + static_cast<double>(*anyFraction()),
                    *anyInteger(-90, 90) * 1.0,
                    static_cast<double>(*anyPositive(-10, 14)),
                    {}};
    const uint32_t width = *rc::gen::inRange(1u, 4097u), height = *rc::gen::inRange(1u, 4097u);
    // In 100 digits: the scene's world is the volume's space.
    const Exact pi = boost::math::constants::pi<Exact>();
    const Exact a = Exact(view.angleDeg) * pi / 180, e = Exact(view.elevationDeg) * pi / 180,
                half = Exact(scene.fovYDeg) * pi / 360;
    const ExactVec up(glm::vec3(scene.up)), wantedFront(glm::vec3(scene.front));
    const ExactVec side = cross(up, wantedFront) * (1 / length(cross(up, wantedFront))), front = cross(side, up);
    const ExactVec backward = (front * cos(a) + side * sin(a)) * cos(e) + up * sin(e);
    const Exact narrower = tan(half) * std::min(1.0, static_cast<double>(width) / height);
    const Exact radius = length(ExactVec(scene.volume->bounds().extent())) / 2;
    const Exact distance = Exact(view.distance) * radius / sin(atan(narrower));
    const ExactVec eye = backward * distance;
    Camera camera;
    try {
      camera = makeCamera(scene, view, width, height);
    } catch (const UsageError&) {
      RC_ASSERT(distance > kFarthest * (1 - 1e-12));
      return;
    }
    RC_ASSERT(distance < kFarthest * (1 + 1e-12));
    RC_ASSERT(isUsable(camera));
    for (const auto& [value, truth] :
         {std::pair(camera.eye.x, eye.x), std::pair(camera.eye.y, eye.y), std::pair(camera.eye.z, eye.z)}) {
      const double error = roundoffs(value, truth, abs(truth) + distance * Exact(kInDouble) / Exact(kUnitRoundoff));
      RC_ASSERT(error <= 1.001);
      worst.see(error);
    }
    for (const auto& [value, truth] : {std::pair(camera.forward.x, backward.x), std::pair(camera.forward.y, backward.y),
                                       std::pair(camera.forward.z, backward.z)}) {
      const double error = roundoffs(-Exact(value), truth, abs(truth) + Exact(kInDouble) / Exact(kUnitRoundoff));
      RC_ASSERT(error <= 1.001);
      worst.see(error);
    }
  });
  record({"makeCamera", "100 digits", "u of each coordinate and 4e-15 of the distance", worst.value(), 1.001});
}

TEST(Case49, ImpossibleViewsAreRefused) {
  Scene scene = blobScene();
  const double nan = std::nan(""), inf = std::numeric_limits<double>::infinity();
  for (const double fov : {0.0, -10.0, 180.0, 360.0, nan, inf, -inf, 1e-320, 179.999999999999}) {
    scene.fovYDeg = fov;
    EXPECT_THROW(makeCamera(scene, {}, 64, 64), UsageError) << fov;
  }
  scene.fovYDeg = 40.0;
  for (const double wrong : {nan, inf, -inf}) {
    EXPECT_THROW(makeCamera(scene, {wrong, 0.0, 1.0, {}}, 64, 64), UsageError);
    EXPECT_THROW(makeCamera(scene, {0.0, wrong, 1.0, {}}, 64, 64), UsageError);
    EXPECT_THROW(makeCamera(scene, {0.0, 0.0, wrong, {}}, 64, 64), UsageError);
    EXPECT_THROW(makeCamera(scene, {0.0, 0.0, 1.0, {0.0, wrong}}, 64, 64), UsageError);
  }
  EXPECT_THROW(makeCamera(scene, {}, 0, 64), UsageError);
  EXPECT_THROW(makeCamera(scene, {}, 64, 0xffffffffu), UsageError);
  scene.front = 3.0 * scene.up;
  EXPECT_THROW(makeCamera(scene, {}, 64, 64), UsageError);
  recordExact("makeCamera, fields of view of 0, 180, NaN", "definition");
}

TEST(Case49, RefusesWhatCannotMakePictures) {
  Camera good;
  good.width = 64;
  good.height = 48;
  EXPECT_TRUE(isUsable(good));
  const float nan = std::nanf(""), inf = std::numeric_limits<float>::infinity();
  const auto refuses = [&](auto change) {
    Camera bad = good;
    change(bad);
    return !isUsable(bad);
  };
  for (const float wrong : {nan, inf, -inf})
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_TRUE(refuses([&](Camera& c) { c.eye[axis] = wrong; }));
      EXPECT_TRUE(refuses([&](Camera& c) { c.right[axis] = wrong; }));
      EXPECT_TRUE(refuses([&](Camera& c) { c.up[axis] = wrong; }));
      EXPECT_TRUE(refuses([&](Camera& c) { c.forward[axis] = wrong; }));
    }
  for (const float wrong : {nan, inf, 0.0f, -0.4f, 1e8f})
    EXPECT_TRUE(refuses([&](Camera& c) { c.tanHalfFovY = wrong; })) << wrong;
  EXPECT_TRUE(refuses([](Camera& c) { c.width = 0; }));
  EXPECT_TRUE(refuses([](Camera& c) { c.height = 0; }));
  EXPECT_TRUE(refuses([](Camera& c) { c.width = kMaxImageSide + 1; }));
  EXPECT_TRUE(refuses([](Camera& c) { c.height = 0xffffffffu; }));
  EXPECT_TRUE(refuses([](Camera& c) { c.width = c.height = kMaxImageSide; }));
  EXPECT_TRUE(refuses([](Camera& c) { c.width = 8192, c.height = 8193; }));
  EXPECT_TRUE(refuses([](Camera& c) { c.width = 4097, c.height = kMaxImageSide; }));
  EXPECT_FALSE(refuses([](Camera& c) { c.width = c.height = 8192; }));
  EXPECT_FALSE(refuses([](Camera& c) { c.width = 4096, c.height = kMaxImageSide; }));
  EXPECT_FALSE(refuses([](Camera& c) { c.width = kMaxImageSide, c.height = 1; }));
  EXPECT_TRUE(refuses([](Camera& c) { c.forward = glm::vec3(0.0f); }));
  EXPECT_TRUE(refuses([](Camera& c) { c.forward *= 2.0f; }));
  EXPECT_TRUE(refuses([](Camera& c) { c.forward = c.up; }));
  EXPECT_TRUE(refuses([](Camera& c) { c.right = c.up; }));
  EXPECT_FALSE(refuses([](Camera& c) { c.right = -c.right; }));  // mirrored is usable
  recordExact("isUsable refuses what makes no pictures", "definition");
}

TEST_P(Case49, MarchersRefuseUnusableCamerasAndGoOn) {
  const MarcherPtr marcher = marcherOn(GetParam(), slab(4), everywhere(0.5f));
  const Camera good = lookingFrom({0.0f, 0.0f, 90.0f}, {}, 24, 24);
  const SampleFrame before = marcher->march(good, {});
  for (const float tangent : {0.0f, std::nanf(""), std::numeric_limits<float>::infinity(), -1.0f}) {
    Camera bad = good;
    bad.tanHalfFovY = tangent;
    EXPECT_THROW(marcher->march(bad, {}), InputError) << tangent;
    EXPECT_TRUE(sameFrame(marcher->march(good, {}), before));
  }
  recordExact("march refuses a camera and goes on with the last good one", "definition", GetParam());
}

TEST_P(Case50, PointsAtOrBehindTheEyeAreNotInFront) {
  Camera camera;
  camera.width = camera.height = 8;
  const auto depthOf = [&](const glm::vec3& point) {
    return evaluate<ProjectProbe>(GetParam(), ProjectProbe::Input{camera, point, 0.01f}).projection.forwardDepth;
  };
  EXPECT_LE(depthOf(camera.eye), 0.0f);
  EXPECT_LE(depthOf(camera.eye + camera.right), 0.0f);
  EXPECT_LT(depthOf(camera.eye - camera.forward), 0.0f);
  EXPECT_GT(depthOf(camera.eye + 1e-3f * camera.forward), 0.0f);
  recordExact("project, points at and behind the eye", "definition", GetParam());
}

/// Shells, seen from inside their matter.
struct InsideShells {
  VolumePtr volume = makeProceduralVolume("shells", {64, 64, 64});
  MarcherPtr marcher;

  explicit InsideShells(Backend backend)
      : marcher(marcherOn(backend, volume, {{{20.0, {0.2f, 0.45f, 0.9f}, 0.0f}, {255.0, {1.0f, 0.5f, 0.2f}, 0.06f}}})) {
  }

  std::vector<Camera> cameras(uint32_t width, uint32_t height) const {
    const float edge = volume->bounds().extent().x;
    std::vector<Camera> all;
    for (const glm::vec3& from :
         {glm::vec3(0.0f), glm::vec3(0.02f, 0.015f, 0.04f), glm::vec3(0.2f, 0.1f, 0.15f), glm::vec3(-0.3f, 0.2f, 0.1f)})
      all.push_back(lookingFrom(edge * from, edge * (from + glm::vec3(-0.3f, -0.2f, -0.9f)), width, height));
    return all;
  }
};

TEST_P(Case62, FromInsideMatterHoldShowsEveryPixelItsOwnSample) {
  const InsideShells shells(GetParam());
  const auto hold = techniqueOn(Backend::cpu, "hold");
  for (const Camera& camera : shells.cameras(160, 120))
    for (const auto& heuristic : kHeuristics) {
      MarchSettings settings;
      settings.sample.heuristic = heuristic.value;
      settings.render.contribution = 1e-4f;
      const auto frame = std::make_shared<const SampleFrame>(shells.marcher->march(camera, settings));
      ASSERT_GT(frame->size(), 10000u) << heuristic.name;
      Image<glm::vec4> truth;
      shells.marcher->render(camera, settings.render, truth);
      hold->setFrame(frame, {});
      WarpedImage image;
      hold->draw(camera, {}, image);
      size_t covered = 0;
      for (uint32_t y = 0; y < camera.height; ++y)
        for (uint32_t x = 0; x < camera.width; ++x) {
          const uint32_t id = image.samples(x, y);
          if (id == kNoSample) continue;
          ++covered;
          ASSERT_EQ(columnOf(frame->samples[id]), x);
          ASSERT_EQ(rowOf(frame->samples[id]), y);
          ASSERT_NEAR(image.color(x, y).a, truth(x, y).a, kDisplayCode);
        }
      EXPECT_EQ(covered, frame->size()) << heuristic.name;
    }
  recordExact("hold from inside matter: every pixel its own sample", "march", GetParam());
}

TEST_P(Case62, FromInsideMatterSamplesLieInTheirPixels) {
  const InsideShells shells(GetParam());
  for (const Camera& camera : shells.cameras(1024, 768)) {
    MarchSettings settings;
    settings.sample.heuristic = Heuristic::entrance;
    settings.render.contribution = 1e-4f;
    const SampleFrame frame = shells.marcher->march(camera, settings);
    const SampleGrid grid = frame.grid();
    const Box& bounds = frame.quantization.bounds;
    for (const PackedSample sample : frame.samples) {
      const glm::vec3 center = unpackPosition(sample, grid);
      const glm::dvec3 offset = glm::dvec3(center) - glm::dvec3(camera.eye);
      const double depth = glm::dot(offset, glm::dvec3(camera.forward)), edge = static_cast<double>(pixelEdge(camera));
      const double x = 0.5 * camera.width + glm::dot(offset, glm::dvec3(camera.right)) / (depth * edge);
      const double y = 0.5 * camera.height - glm::dot(offset, glm::dvec3(camera.up)) / (depth * edge);
      // What rounding is declared to move a sample by, of coordinates up to 64: pixels are wide enough from a hundredth
      // of a voxel on.
      if (depth < 0.05 || glm::any(glm::equal(center, bounds.lower)) || glm::any(glm::equal(center, bounds.upper)))
        continue;
      ASSERT_NEAR(x, columnOf(sample) + 0.5, 0.5 * (0.01 + 64.0 * 0x1p-20 / (depth * edge)));
      ASSERT_NEAR(y, rowOf(sample) + 0.5, 0.5 * (0.01 + 64.0 * 0x1p-20 / (depth * edge)));
    }
  }
  recordExact("samples seen from inside matter lie in their pixels", "double", GetParam());
}

TEST_P(Case62, FromInsideMatterDepthsAreWithinHalfAStep) {
  // Matter that is opaque everywhere: the first sample is half a step in front of the eye.
  const VolumePtr volume = makeTestVolume(VoxelType::uint8, {16, 16, 16}, [](const glm::ivec3&) { return 50.0; });
  const MarcherPtr marcher = marcherOn(GetParam(), volume, everywhere(1.0f));
  for (const float step : {0.001f, 0.01f, 0.5f}) {
    MarchSettings settings;
    settings.render.step = step;
    settings.sample.heuristic = Heuristic::entrance;
    const Camera camera = lookingFrom({1.0f, 2.0f, 3.0f}, {}, 40, 30);
    const SampleFrame frame = marcher->march(camera, settings);
    ASSERT_EQ(frame.size(), 1200u);
    EXPECT_EQ(frame.quantization.nearDepth, 0.0f);
    for (size_t i = 0; i < frame.size(); ++i) {
      const PackedSample sample = frame.samples[i];
      const double cosine = static_cast<double>(frame.grid().pixels.ray(columnOf(sample), rowOf(sample)).cosine);
      const double depthStep = static_cast<double>(frame.quantization.depthStep);
      ASSERT_NEAR(static_cast<double>(depthCode(sample)) * depthStep, 0.5 * static_cast<double>(step) * cosine,
                  0.5001 * depthStep);
    }
  }
  recordExact("depths from inside opaque matter: half a code", "closed form in double", GetParam());
}

}  // namespace
}  // namespace warpscope
