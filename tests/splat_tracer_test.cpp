// Splats show what brute force and the hierarchy show, bit for bit: tangent, tiny, huge, coincident and flat clouds, the eye among them,
// any image, any number of threads, and clouds that would make lists of tiles large.
// Mirrors render/warp/splats/splat_tracer.h and screen_bins.h.
#include "render/warp/splats/splat_tracer.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <random>

#include "render/base/error.h"
#include "render/warp/splats/screen_bins.h"
#include "tests/sphere_clouds.h"
#include "tests/stability/cloud_cases.h"
#include "tests/traced_picture.h"

namespace warpscope {
namespace {

size_t coveredPixels(const TracedPicture& seen) {
  return static_cast<size_t>(std::count_if(seen.ids.begin(), seen.ids.end(), [](uint32_t id) { return id != kNoSample; }));
}

/// Returns how many pixels are covered.
size_t expectSameAs(std::span<const Sphere> cloud, const Camera& camera, bool byBruteForce = true) {
  const TracedPicture splats = tracedPicture<SplatTracer>(cloud, camera);
  const TracedPicture lbvh = tracedPicture<LbvhTracer>(cloud, camera);
  EXPECT_EQ(splats.ids, lbvh.ids);
  EXPECT_EQ(splats.depth, lbvh.depth);
  if (byBruteForce) {
    const TracedPicture brute = tracedPicture<BruteForceTracer>(cloud, camera);
    EXPECT_EQ(splats.ids, brute.ids);
    EXPECT_EQ(splats.depth, brute.depth);
  }
  return coveredPixels(splats);
}

Camera inside(uint32_t width, uint32_t height) {
  Camera camera = orbitCamera(0.0f, 20.0f, width, height);
  camera.eye = {0.01f, -0.02f, 0.03f};
  camera.tanHalfFovY = 1.2f;
  return camera;
}

TEST(SplatTracer, EqualsTheOthersOnAllClouds) {
  checkProperty([] {
    const CloudCase c = *rc::gen::resize(rc::kNominalSize, anyCloudCase({150, 140}));  // large from the first on
    // From points to spheres that hold most of the cloud.
    const float size = *anyPositive(-10, 4);
    auto cloud = c.cloud();
    for (size_t i = 0; i < cloud.size(); i += 4) cloud[i].radius *= size;
    expectSameAs(cloud, c.camera);
  });
}

TEST(SplatTracer, HoldsNoneOneAndTwoSpheres) {
  const std::vector<Sphere> cloud{{{0.0f, 0.0f, 0.0f}, 1.0f}, {{1.0f, 0.0f, 0.5f}, 1.0f}};
  for (size_t count = 0; count <= 2; ++count)
    EXPECT_EQ(expectSameAs(std::span(cloud).first(count), orbitCamera(6.0f, 15.0f, 67, 43)) > 0, count > 0);
}

TEST(SplatTracer, CoincidentSpheresShowTheLowestId) {
  const std::vector<Sphere> cloud(1000, Sphere{{1.0f, 2.0f, 3.0f}, 0.5f});
  const Camera camera = orbitCamera(20.0f, 30.0f, 130, 120);
  EXPECT_GT(expectSameAs(cloud, camera), 0u);
  for (const uint32_t id : tracedPicture<SplatTracer>(cloud, camera).ids) EXPECT_TRUE(id == 0 || id == kNoSample);
}

TEST(SplatTracer, TangentAndGrazingSpheres) {
  // Rows of spheres that touch each other, seen along the rows, and some whose outline passes pixel centres exactly.
  std::vector<Sphere> cloud;
  for (int x = -8; x <= 8; ++x)
    for (int y = -8; y <= 8; ++y)
      for (int z = -8; z <= 8; ++z) cloud.push_back({{static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)}, 0.5f});
  Camera camera;
  camera.width = camera.height = 129;
  camera.tanHalfFovY = 1.0f;
  for (const float z : {64.0f, 20.5f, 9.0f, 8.5f, 0.5f}) {
    camera.eye = {0.0f, 0.0f, z};
    EXPECT_GT(expectSameAs(cloud, camera), 0u) << z;
    camera.eye = {0.5f, 0.5f, z};
    expectSameAs(cloud, camera);
  }
}

TEST(SplatTracer, TinySpheresBetweenPixelsAndHugeOnesBehind) {
  auto cloud = makeCloud(CloudShape::random, 3000, 1.0f, 31);
  for (Sphere& sphere : cloud) sphere.radius *= 1e-4f;
  expectSameAs(cloud, orbitCamera(3.0f, 12.0f, 97, 81));
  // Farther than anything else, and in front of everything with a surface that fills the picture.
  cloud.insert(cloud.begin() + 7, Sphere{{0.0f, 0.0f, -1e4f}, 9998.5f});
  cloud.insert(cloud.begin() + 900, Sphere{{0.0f, 0.0f, -1e7f}, 9.999e6f});
  EXPECT_GT(expectSameAs(cloud, orbitCamera(3.0f, 40.0f, 97, 81)), 1000u);
}

TEST(SplatTracer, FromInsideTheCloud) {
  for (const CloudShape shape : kCloudShapes) {
    auto cloud = makeCloud(shape, 4000, 1.0f, 77);
    const size_t covered = expectSameAs(cloud, inside(150, 110));
    EXPECT_TRUE(covered > 0 || shape == CloudShape::planar || shape == CloudShape::collinear) << "those may lie behind the eye";
    // So large that the eye is in many of them.
    for (Sphere& sphere : cloud) sphere.radius *= 20.0f;
    expectSameAs(cloud, inside(70, 65));
  }
}

TEST(SplatTracer, FarFromTheCoordinatesOrigin) {
  auto cloud = makeCloud(CloudShape::clustered, 500, 100.0f, 11);
  Camera camera = orbitCamera(300.0f, 70.0f, 161, 147);
  for (Sphere& sphere : cloud) sphere.center += glm::vec3(1e7f, -1e7f, 1e7f);
  camera.eye += glm::vec3(1e7f, -1e7f, 1e7f);
  EXPECT_GT(expectSameAs(cloud, camera), 0u);
}

TEST(SplatTracer, ImagesOfAllShapes) {
  const auto cloud = makeCloud(CloudShape::clustered, 500, 1.0f, 5);
  for (const glm::uvec2 size : {glm::uvec2(1, 1), glm::uvec2(32, 32), glm::uvec2(33, 31), glm::uvec2(1, 700), glm::uvec2(16384, 1),
                                glm::uvec2(1000, 3), glm::uvec2(257, 256)}) {
    SCOPED_TRACE(std::to_string(size.x) + "x" + std::to_string(size.y));
    expectSameAs(cloud, orbitCamera(2.0f, 80.0f, size.x, size.y), size.x < 10'000);
  }
}

TEST(SplatTracer, ManySpheresThatCoverMuchEach) {
  // Near and far layers of spheres that each cover hundreds to thousands of pixels, most of them hidden.
  auto cloud = makeCloud(CloudShape::random, 200'000, 1.0f, 3);
  for (Sphere& sphere : cloud) sphere.radius *= 2.0f;
  EXPECT_GT(expectSameAs(cloud, orbitCamera(3.0f, 0.0f, 512, 512), false), 50'000u);
  EXPECT_GT(expectSameAs(cloud, inside(512, 512), false), 50'000u);
}

TEST(SplatTracer, IsTheSameForAnyNumberOfThreads) {
  const std::vector<Sphere> cloud = makeCloudOfTies();
  const Camera camera = orbitCamera(15.0f, 33.0f, 328, 296);
  TracedPicture expected;
  for (const size_t threads : {1, 2, 7}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    const TracedPicture seen = tracedPicture<SplatTracer>(cloud, camera);
    if (threads == 1) expected = seen;
    EXPECT_EQ(seen.ids, expected.ids);
    EXPECT_EQ(seen.depth, expected.depth);
  }
  EXPECT_GT(coveredPixels(expected), 10'000u);
}

TEST(SplatTracer, RefusesWhatCannotBeTracedAndForgetsTheLastCloud) {
  SplatTracer tracer;
  std::vector<Sphere> cloud(3, Sphere{glm::vec3(0.0f), 1.0f});
  tracer.build(cloud);
  cloud[1].radius = std::nanf("");
  EXPECT_THROW(tracer.build(cloud), InputError);
  Image<uint32_t> ids;
  tracer.trace(orbitCamera(5.0f, 0.0f, 8, 8), ids, nullptr, {});
  EXPECT_EQ(ids, Image<uint32_t>(8, 8, kNoSample));
}

TEST(SplatTracer, CancelledTracingThrows) {
  SplatTracer tracer;
  tracer.build(makeCloud(CloudShape::random, 100, 1.0f, 1));
  std::stop_source source;
  source.request_stop();
  Image<uint32_t> ids;
  EXPECT_THROW(tracer.trace(orbitCamera(3.0f, 0.0f, 64, 64), ids, nullptr, source.get_token()), OperationCancelled);
}

TEST(ScreenBins, EverySphereIsInEveryTileItReachesAndInFourAtMost) {
  auto cloud = makeCloud(CloudShape::random, 2000, 1.0f, 8);
  std::mt19937 random(9);
  for (Sphere& sphere : cloud) sphere.radius *= std::pow(10.0f, std::uniform_real_distribution<float>(-2.0f, 1.4f)(random));
  const Camera camera = orbitCamera(2.5f, 10.0f, 1000, 530);
  const ScreenBins bins(camera, cloud, {});
  std::vector<uint32_t> entries(cloud.size(), 0);
  size_t large = 0;
  for (uint32_t level = 0; level < bins.levels(); ++level) {
    const uint32_t side = kSplatTileSide << level;
    for (uint32_t y = 0; y < camera.height; y += side)
      for (uint32_t x = 0; x < camera.width; x += side) {
        const auto bin = bins.bin(level, x, y);
        for (size_t i = 0; i < bin.size(); ++i) {
          const SplatFootprint& footprint = bins.footprint(bin[i]);
          ++entries[bin[i]];
          EXPECT_TRUE(footprint.x0 < x + side && footprint.x1 > x && footprint.y0 < y + side && footprint.y1 > y);
          EXPECT_TRUE(level == 0 || i == 0 || bins.footprint(bin[i - 1]).nearest <= footprint.nearest);
          EXPECT_TRUE(level > 0 || i == 0 || bin[i - 1] < bin[i]);
          large += level > 0;
        }
      }
  }
  EXPECT_GT(large, 100u);
  for (uint32_t i = 0; i < cloud.size(); ++i) {
    const SplatFootprint& footprint = bins.footprint(i);
    EXPECT_LE(entries[i], 4u);
    EXPECT_EQ(entries[i] > 0, footprint.x1 > 0);
    if (footprint.x1 == 0) continue;
    EXPECT_TRUE(footprint.x0 < footprint.x1 && footprint.y0 < footprint.y1 && footprint.x1 <= 1000 && footprint.y1 <= 530);
    const Ray ray = pixelRay(camera, 0.5f * glm::vec2(footprint.x0 + footprint.x1, footprint.y0 + footprint.y1));
    EXPECT_LE(footprint.nearest, intersectSphere(ray, cloud[i].center, cloud[i].radius));
  }
}

}  // namespace
}  // namespace warpscope
