// The textbook's forms are what they say, and are wrong where they are known to be: else nothing is shown by comparing with them.
// Mirrors render/core/arithmetic.h, textbook_sphere.h, textbook_table.h and render/march/march_arithmetic.h.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "render/base/error.h"
#include "render/core/textbook_sphere.h"
#include "render/core/textbook_table.h"
#include "render/march/march_arithmetic.h"
#include "render/march/marcher_cpu.h"
#include "render/volume/torture_volume.h"
#include "render/warp/arithmetic_knob.h"
#include "render/warp/lbvh/sphere_tracer.h"
#include "render/warp/spheres_warp.h"
#include "tests/marcher_cases.h"
#include "tests/sphere_clouds.h"
#include "tests/test_volumes.h"

namespace warpscope {
namespace {

RenderSettings textbook() {
  RenderSettings settings;
  settings.arithmetic = Arithmetic::textbook;
  return settings;
}

TEST(TextbookSphere, AgreesWhereNothingIsHard) {
  const Ray ray{{0.0f, 0.0f, 10.0f}, {0.0f, 0.0f, -1.0f}};
  for (const float beside : {0.0f, 0.5f, 2.0f}) {
    const glm::vec3 center(beside, 0.0f, 0.0f);
    EXPECT_NEAR(intersectSphereTextbook(ray, center, 3.0f), intersectSphere(ray, center, 3.0f), 1e-5f) << beside;
  }
  EXPECT_EQ(intersectSphereTextbook(ray, {4.0f, 0.0f, 0.0f}, 3.0f), kNoHit);
  EXPECT_EQ(intersectSphereTextbook(ray, {0.0f, 0.0f, 20.0f}, 3.0f), kNoHit);  // behind
}

TEST(TextbookSphere, LosesSmallSpheresFarAway) {
  // Case 2: a ray that passes 1.001 radii beside the centre, ten thousand radii away, and case 1: one that hits.
  int wrong = 0;
  for (int i = 0; i < 100; ++i) {
    const float distance = 1e4f + 37.0f * static_cast<float>(i);
    const Ray ray{{0.0f, 0.0f, 0.0f}, {0.0f, 0.0f, 1.0f}};
    wrong += intersectSphereTextbook(ray, {1.001f, 0.0f, distance}, 1.0f) != kNoHit;
    wrong += intersectSphereTextbook(ray, {0.5f, 0.0f, distance}, 1.0f) == kNoHit;
    EXPECT_EQ(intersectSphere(ray, {1.001f, 0.0f, distance}, 1.0f), kNoHit);
    EXPECT_NE(intersectSphere(ray, {0.5f, 0.0f, distance}, 1.0f), kNoHit);
  }
  EXPECT_GT(wrong, 20);
}

TEST(TextbookSphere, SeesNoneThatItIsInsideOf) {
  const Ray ray{{0.0f, 0.0f, 0.1f}, {0.0f, 0.0f, 1.0f}};
  EXPECT_EQ(intersectSphereTextbook(ray, {0.0f, 0.0f, 0.5f}, 1.0f), kNoHit);
  EXPECT_LT(intersectSphere(ray, {0.0f, 0.0f, 0.5f}, 1.0f), kNoHit);
}

TEST(TextbookTable, HoldsTheFunctionAtItsEntriesAndNothingBetween) {
  const TransferFunction ramp{{{0.0, glm::vec3(1.0f), 0.0f}, {1.0, glm::vec3(1.0f), 1.0f}}};
  const TransferTable table = bakeTextbookTable(ramp, {0.0f, 1.0f, false}, 1.0f);
  for (int i = 0; i < 4096; ++i)
    EXPECT_NEAR(table.alphas[static_cast<size_t>(i)], static_cast<float>(i) / 4095.0f, 1e-6f);
  EXPECT_EQ(table.lookup().entryOf(0.5f), 2048);
  EXPECT_EQ(table.lookup().entryOf(2.0f), 4095);
  EXPECT_EQ(table.lookup().entryOf(-1.0f), 0);
  // Case 59: a label that lies between two entries is not there.
  const TransferFunction label{{{0.0, glm::vec3(1.0f), 0.0f},
                                {30001.0, glm::vec3(1.0f), 0.0f},
                                {30001.0, glm::vec3(1.0f), 1.0f},
                                {30002.0, glm::vec3(1.0f), 1.0f},
                                {30002.0, glm::vec3(1.0f), 0.0f},
                                {65535.0, glm::vec3(1.0f), 0.0f}}};
  EXPECT_FALSE(bakeTextbookTable(label, {0.0f, 65535.0f, true}, 1.0f).anyVisible(0.0f, 65535.0f));
}

TEST(TextbookMarch, LosesWhatEachFormIsKnownToLose) {
  // Case 30: opacity of 1e-8, and case 34: transmittance that stalls.
  AccumulatedOpacity accumulated;
  Transmittance transmittance;
  for (int i = 0; i < 1000000; ++i) {
    accumulated.pass(1e-8f);
    transmittance.pass(1e-8f);
  }
  const double truth = -std::expm1(1e6 * std::log1p(-1e-8));
  EXPECT_NEAR(transmittance.opacity(), truth, 1e-9);
  EXPECT_GT(std::abs(static_cast<double>(accumulated.opacity()) - truth), 1e-6);

  // Case 36: t += dt.
  RayLattice lattice;
  lattice.t0 = 1e4f;
  lattice.length = 1.0f;
  lattice.dt = 1e-4f;
  lattice.count = 10000;
  TextbookMarch::Places places(lattice);
  float t = 0.0f;
  for (int i = 0; i < lattice.count; ++i) t = places.next(lattice, i);
  EXPECT_EQ(t, 1e4f) << "it never got on";
}

TEST(TextbookMarch, DrawsNearlyTheSamePictureWhereNothingIsHard) {
  const VolumePtr volume = makeTestVolume(VoxelType::uint8, {24, 24, 24}, [](const glm::ivec3& p) { return 10.0 * (p.x + p.y % 3); });
  const MarcherPtr marcher = makeCpuMarcher(volume, {{{20.0, {1.0f, 0.5f, 0.0f}, 0.0f}, {255.0, {0.0f, 0.5f, 1.0f}, 0.2f}}});
  const Camera camera = lookingFrom({20.0f, 30.0f, 40.0f}, {}, 48, 32);
  Image<glm::vec4> stable, other;
  marcher->render(camera, {}, stable);
  marcher->render(camera, textbook(), other);
  bool differs = false;
  for (size_t i = 0; i < stable.size(); ++i) {
    for (int channel = 0; channel < 4; ++channel) ASSERT_NEAR(other[i][channel], stable[i][channel], 4e-3f);
    differs |= other[i] != stable[i];
  }
  EXPECT_TRUE(differs);
  // What was baked for one is not taken for the other.
  Image<glm::vec4> again;
  marcher->render(camera, {}, again);
  for (size_t i = 0; i < stable.size(); ++i) ASSERT_EQ(again[i], stable[i]);
}

TEST(TextbookMarch, FindsNoSamples) {
  const MarcherPtr marcher = makeCpuMarcher(makeTortureVolume("torture/thin-slab"), everywhere(0.5f));
  MarchSettings settings;
  settings.render.arithmetic = Arithmetic::textbook;
  EXPECT_THROW(marcher->march(lookingFrom({0.0f, 0.0f, 90.0f}, {}, 8, 8), settings), UsageError);
}

/// Pixels in which packets of rays see another sphere than single ones.
size_t apartFromSingleRays(const std::vector<Sphere>& cloud, const Camera& camera) {
  LbvhTracer tracer(Arithmetic::textbook);
  tracer.build(cloud);
  Image<uint32_t> ids;
  tracer.trace(camera, ids, nullptr, {});
  size_t apart = 0;
  for (uint32_t y = 0; y < camera.height; ++y)
    for (uint32_t x = 0; x < camera.width; ++x) {
      const Ray ray = pixelRay(camera, {static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f});
      apart += closestHit<TextbookSphere>(tracer.view(), ray).id != ids(x, y);
    }
  return apart;
}

TEST(TextbookTracing, ThePacketsAreClosestHitsByTheSameForm) {
  const Camera camera = lookingFrom({30.0f, 20.0f, 400.0f}, {}, 40, 30, 0.2f);
  // Packets leave out spheres that pass too far away in truth; single rays meet them if their box is hit.
  EXPECT_LT(apartFromSingleRays(makeCloud(CloudShape::random, 500, 30.0f, 7), camera), size_t{camera.width} * camera.height / 50);
}

TEST(TextbookTracing, SpheresAreWholeHoweverNearTheEyeIs) {
  for (const float radius : {0.3f, 0.6f, 0.9f})
    EXPECT_EQ(apartFromSingleRays({{{0.0f, 0.0f, 0.0f}, radius}}, lookingFrom({0.0f, 0.0f, 1.0f}, {}, 128, 96, 1.0f)), 0u) << radius;
}

TEST(TextbookTracing, OnlyTheLbvhKnowsIt) {
  WarpSettings settings;
  settings.knobs.set(kArithmeticKnob, Arithmetic::textbook);
  for (const auto& tracing : kSphereTracings) {
    settings.knobs.set(kSphereTracingKnob, tracing.value);
    const bool isKnown = tracing.value == SphereTracing::automatic || tracing.value == SphereTracing::lbvh;
    if (isKnown)
      EXPECT_NO_THROW(requireTraceable(settings));
    else
      EXPECT_THROW(requireTraceable(settings), UsageError) << tracing.name;
  }
}

TEST(TortureVolume, EachIsThereAndAsItSays) {
  for (const TortureVolume& torture : kTortureVolumes) {
    const VolumePtr volume = makeTortureVolume(torture.name);
    EXPECT_EQ(volume->name(), torture.name);
    EXPECT_LT(volume->statistics().lowest, volume->statistics().highest + 1.0);
  }
  EXPECT_EQ(makeTortureVolume("torture/outlier")->statistics().lowest, -9999.0);
  const VolumePtr sprinkled = makeTortureVolume("torture/nan-sprinkled");
  EXPECT_NEAR(static_cast<double>(sprinkled->statistics().nonFinite) / static_cast<double>(sprinkled->voxelCount()), 0.01, 0.003);
  EXPECT_THROW(makeTortureVolume("torture/outliar"), InputError);
}

}  // namespace
}  // namespace warpscope
