// Loads against sums over every sphere's own footprint, and which way is taken where the answer is plain.
// Mirrors render/warp/sphere_ways.h.
#include "render/warp/sphere_ways.h"

#include <gtest/gtest.h>

#include "render/warp/splats/footprint_limits.h"
#include "render/warp/splats/sphere_footprint.h"
#include "tests/frame_samples.h"
#include "tests/sphere_clouds.h"

namespace warpscope {
namespace {

struct Exact {
  double fragments = 0.0, longest = 0.0;
};

Exact exactOf(const SampleFrame& frame, const Camera& camera) {
  Exact exact;
  const FootprintView view = footprintViewOf(camera);
  for (size_t i = 0; i < frame.size(); ++i) {
    const PixelRect rect = sphereFootprint(view, sphereOf(frame, i));
    if (rect.isEmpty()) continue;
    const double area = static_cast<double>(rect.x1 - rect.x0) * (rect.y1 - rect.y0);
    exact.fragments += area;
    exact.longest = std::max(exact.longest, area);
  }
  return exact;
}

TEST(SphereWays, FewSpheresAreAllLookedAt) {
  for (const size_t count : {size_t{1}, size_t{2}, size_t{511}, size_t{512}}) {
    const SampleFrame frame = frameOfCloud(makeCloud(CloudShape::random, count, 100.0f, 3));
    const Camera camera = orbitCamera(300.0f, 20.0f, 193, 161);
    const SphereLoad load = SphereLoadProbe(frame).loadFor(camera);
    const Exact exact = exactOf(frame, camera);
    EXPECT_NEAR(load.fragments, exact.fragments, 1e-9 * exact.fragments) << count;
    EXPECT_EQ(load.longestWalk, std::min<double>(exact.longest, kPixelsOfWarp)) << count;
    EXPECT_EQ(load.spheres, static_cast<double>(count));
    EXPECT_EQ(load.pixels, 193.0 * 161.0);
    EXPECT_LE(load.tiles, load.fragments);
    EXPECT_GE(load.tiles, load.fragments / 64.0);
  }
}

TEST(SphereWays, SomeStandForMany) {
  const SampleFrame frame = frameOfCloud(makeCloud(CloudShape::random, 40000, 100.0f, 5));
  for (const float distance : {200.0f, 300.0f, 3000.0f}) {
    const Camera camera = orbitCamera(distance, 20.0f, 640, 480);
    const double exact = exactOf(frame, camera).fragments;
    EXPECT_NEAR(SphereLoadProbe(frame).loadFor(camera).fragments, exact, 0.25 * exact) << distance;
  }
}

/// Samples come row by row: what stands for all must not be of few columns.
TEST(SphereWays, EveryColumnOfAPictureCounts) {
  constexpr uint32_t kSide = 512;
  SampleFrame frame;
  frame.camera = orbitCamera(300.0f, 0.0f, kSide, kSide);
  frame.quantization.radiusUnit = 1.0f;
  frame.quantization.bounds = {glm::vec3(-1000.0f), glm::vec3(1000.0f)};
  frame.quantization.depthStep = 0x1p-10f;
  for (uint32_t pixel = 0; pixel < kSide * kSide; ++pixel) {
    const uint32_t column = pixel % kSide;
    frame.samples.push_back(packSample(column, pixel / kSide, 100.0f + static_cast<float>(column), 1.0f, frame.quantization));
  }
  frame.colors.resize(frame.samples.size());
  const double exact = exactOf(frame, frame.camera).fragments;
  EXPECT_NEAR(SphereLoadProbe(frame).loadFor(frame.camera).fragments, exact, 0.1 * exact);
}

TEST(SphereWays, NothingIsNoWork) {
  const SphereLoad load = SphereLoadProbe(SampleFrame{}).loadFor(orbitCamera(300.0f, 0.0f, 64, 48));
  EXPECT_EQ(load.spheres, 0.0);
  EXPECT_EQ(load.fragments, 0.0);
  EXPECT_EQ(load.tiles, 0.0);
  EXPECT_EQ(load.longestWalk, 0.0);
  for (const WayCosts& costs : {sphereCosts(load), surfaceCosts(load, 4)}) EXPECT_TRUE(costs.favourFootprints());
  // Spheres that lie behind the eye alone.
  Camera away = orbitCamera(1000.0f, 0.0f, 64, 48);
  away.forward = -away.forward;
  away.right = -away.right;
  EXPECT_EQ(SphereLoadProbe(frameOfCloud(makeCloud(CloudShape::random, 1000, 100.0f, 7))).loadFor(away).fragments, 0.0);
}

TEST(SphereWays, SmallSpheresLookForPixelsAndLargeOnesAreLookedFor) {
  const SampleFrame frame = frameOfCloud(makeCloud(CloudShape::random, 300000, 100.0f, 11));
  const SphereLoadProbe probe(frame);
  const SphereLoad far = probe.loadFor(orbitCamera(2000.0f, 20.0f, 1024, 1024)), near = probe.loadFor(orbitCamera(20.0f, 20.0f, 4096, 4096));
  for (const WayCosts& costs : {sphereCosts(far), surfaceCosts(far, 4)}) EXPECT_TRUE(costs.favourFootprints());
  for (const WayCosts& costs : {sphereCosts(near), surfaceCosts(near, 4)}) EXPECT_FALSE(costs.favourFootprints());
}

TEST(SphereWays, OnTheCpuLargeFootprintsAloneAreLeftToTheHierarchy) {
  const SampleFrame frame = frameOfCloud(makeCloud(CloudShape::random, 300000, 100.0f, 11));
  const SphereLoadProbe probe(frame);
  EXPECT_TRUE(hostFavoursFootprints(probe.loadFor(orbitCamera(2000.0f, 20.0f, 1024, 1024))));
  EXPECT_TRUE(hostFavoursFootprints(probe.loadFor(orbitCamera(300.0f, 20.0f, 1024, 1024))));
  EXPECT_TRUE(hostFavoursFootprints(SphereLoadProbe(SampleFrame{}).loadFor(orbitCamera(300.0f, 0.0f, 64, 48))));
  SphereLoad load{.pixels = 1e6, .spheres = 100.0, .fragments = 100.0 * kLargeFootprint};
  EXPECT_TRUE(hostFavoursFootprints(load));
  load.fragments *= 1.001;
  EXPECT_FALSE(hostFavoursFootprints(load));
}

/// More of anything costs no less.
TEST(SphereWays, CostsGrow) {
  const SphereLoad load{.pixels = 1e6, .spheres = 4e5, .fragments = 3e7, .tiles = 1e6, .longestWalk = 100.0};
  for (double SphereLoad::* part : {&SphereLoad::pixels, &SphereLoad::spheres, &SphereLoad::fragments, &SphereLoad::tiles, &SphereLoad::longestWalk}) {
    SphereLoad more = load;
    more.*part *= 2.0;
    const WayCosts spheres = sphereCosts(load), moreSpheres = sphereCosts(more), surfaces = surfaceCosts(load, 4), moreSurfaces = surfaceCosts(more, 4);
    EXPECT_GE(moreSpheres.footprints, spheres.footprints);
    EXPECT_GE(moreSpheres.hierarchy, spheres.hierarchy);
    EXPECT_GE(moreSurfaces.footprints, surfaces.footprints);
    EXPECT_GE(moreSurfaces.hierarchy, surfaces.hierarchy);
    EXPECT_GT(moreSpheres.footprints + moreSpheres.hierarchy, spheres.footprints + spheres.hierarchy);
  }
}

}  // namespace
}  // namespace warpscope
