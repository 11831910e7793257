// The hierarchy: cases 7, 11, 12 and 19 to 25. Structure by the paper's definitions; pictures by brute force, bit for
// bit, and by Embree but for rounding. Mirrors render/warp/lbvh/lbvh.h and what draws by it; techniques on either
// backend.
#include "render/warp/lbvh/lbvh.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cstring>
#include <functional>
#include <random>

#include "render/base/error.h"
#include "render/warp/lbvh/embree_tracer.h"
#include "render/warp/lbvh/sphere_tracer.h"
#include "render/warp/multihit_warp.h"
#include "render/warp/spheres_warp.h"
#include "tests/frame_samples.h"
#include "tests/sphere_clouds.h"
#include "tests/stability/backends.h"
#include "tests/stability/cloud_cases.h"
#include "tests/stability/record.h"
#include "tests/traced_picture.h"

namespace warpscope {
namespace {

/// Checks everything that traversal relies on and returns the number of inner nodes on the longest path.
uint32_t checkStructure(const Lbvh& lbvh, std::span<const Sphere> cloud) {
  const GroupedLbvhView view = lbvh.view();
  std::vector<uint32_t> ids(view.ids, view.ids + view.count);
  std::sort(ids.begin(), ids.end());
  for (uint32_t i = 0; i < view.count; ++i) EXPECT_EQ(ids[i], i) << "every sphere once";
  Box centers;
  for (const Sphere& sphere : cloud) centers.include(sphere.center);
  std::vector<uint64_t> all;  // the code of every sphere
  for (uint32_t i = 0; i < view.count; ++i) all.push_back(mortonCodeOf(view.spheres[i].center, centers));
  EXPECT_TRUE(std::is_sorted(all.begin(), all.end()));

  // Leaves are the largest subtrees of no more than so many spheres.
  const uint64_t* codes = lbvh.codes().data();
  uint32_t leaf = 0;
  const std::function<void(MortonRange)> expectLeaves = [&](MortonRange spheres) {
    if (spheres.last - spheres.first >= kLeafSpheres) {
      const uint32_t split = findSplit(all.data(), view.count, spheres);
      expectLeaves({spheres.first, split});
      expectLeaves({split + 1, spheres.last});
      return;
    }
    ASSERT_LT(leaf, view.leaves);
    EXPECT_EQ(codes[leaf], all[spheres.first]);
    EXPECT_EQ(view.spheresOf(leaf++), spheres);
  };
  if (view.count > 0) expectLeaves({0, view.count - 1});
  EXPECT_EQ(leaf, view.leafCount());

  uint32_t visitedNodes = 0, visitedLeaves = 0, deepest = 0;
  const auto smallestRadius = [&](MortonRange leaves) {
    float smallest = kNoHit;
    for (uint32_t i = view.spheresOf(leaves.first).first; i <= view.spheresOf(leaves.last).last; ++i)
      smallest = std::min(smallest, view.spheres[i].radius);
    return smallest;
  };
  const std::function<Box(uint32_t, MortonRange, uint32_t)> visit = [&](uint32_t reference, MortonRange leaves,
                                                                        uint32_t depth) {
    Box bounds;
    if (reference & kLbvhLeafBit) {
      EXPECT_EQ(leaves, (MortonRange{visitedLeaves, visitedLeaves}));
      EXPECT_EQ(reference & ~kLbvhLeafBit, visitedLeaves);
      const MortonRange spheres = view.spheresOf(visitedLeaves++);
      for (uint32_t i = spheres.first; i <= spheres.last; ++i) bounds.include(sphereBounds(view.spheres[i]));
      return bounds;
    }
    ++visitedNodes;
    deepest = std::max(deepest, depth);
    const LbvhNode& node = view.nodes[reference];
    EXPECT_EQ(determineRange(codes, view.leaves, reference), leaves) << "a thread per node finds what the walk found";
    const uint32_t split = findSplit(codes, view.leaves, leaves);
    EXPECT_EQ(node.child[0], leftReference(leaves, split));
    EXPECT_EQ(node.child[1], rightReference(leaves, split));
    EXPECT_EQ(node.smallestRadius[0], smallestRadius({leaves.first, split}));
    EXPECT_EQ(node.smallestRadius[1], smallestRadius({split + 1, leaves.last}));
    EXPECT_EQ(node.bounds[0], visit(node.child[0], {leaves.first, split}, depth + 1));
    EXPECT_EQ(node.bounds[1], visit(node.child[1], {split + 1, leaves.last}, depth + 1));
    bounds = node.bounds[0];
    bounds.include(node.bounds[1]);
    return bounds;
  };
  if (view.leaves > 1) visit(0, {0, view.leaves - 1}, 1);
  EXPECT_EQ(visitedNodes, view.leaves > 1 ? view.leaves - 1 : 0);
  EXPECT_EQ(visitedLeaves, view.leaves > 1 ? view.leaves : 0);
  EXPECT_LE(deepest, kMaxLbvhDepth);
  return deepest;
}

/// What is certain about a ray and a sphere when every operation rounds: double has 29 bits more than float.
struct Truth {
  bool decided;      ///< the ray neither grazes the sphere nor starts from its surface, within rounding
  double t;          ///< of the first root
  double tolerance;  ///< of t
};

Truth judge(const Ray& ray, const Sphere& sphere) {
  const glm::dvec3 toCenter = glm::dvec3(sphere.center) - glm::dvec3(ray.origin);
  const glm::dvec3 direction = glm::normalize(glm::dvec3(ray.direction));
  const double along = glm::dot(toCenter, direction);
  const double beside = glm::length(toCenter - along * direction);
  const double distance = glm::length(toCenter);
  const double radius = sphere.radius;
  // Embree's reciprocals are a Newton step off the last bit: twice the oracle's band of intersectSphere.
  const double band = 16.0 / 16777216.0 * (distance + radius);
  if (std::abs(beside - radius) <= band || std::abs(distance - radius) <= band) return {false, 0.0, 0.0};
  const double half = std::sqrt(std::max(0.0, radius * radius - beside * beside));
  return {true, along - half, half > 0.0 ? band * (1.0 + radius / half) : band};
}

/// The first pixel in which `other` differs from `truth` by more than rounding explains, or an empty text.
std::string firstDifference(const Camera& camera, std::span<const Sphere> cloud, const TracedPicture& truth,
                            const TracedPicture& other) {
  for (uint32_t y = 0; y < camera.height; ++y) {
    for (uint32_t x = 0; x < camera.width; ++x) {
      const uint32_t a = truth.ids(x, y), b = other.ids(x, y);
      if (a == b) continue;
      const Ray ray = pixelRay(camera, {x + 0.5f, y + 0.5f});
      const Truth ta = a == kNoSample ? Truth{true, kNoHit, 0.0} : judge(ray, cloud[a]);
      const Truth tb = b == kNoSample ? Truth{true, kNoHit, 0.0} : judge(ray, cloud[b]);
      if (!ta.decided || !tb.decided || std::abs(ta.t - tb.t) <= ta.tolerance + tb.tolerance) continue;
      return "pixel " + std::to_string(x) + "," + std::to_string(y) + ": sphere " + std::to_string(a) + " at " +
             std::to_string(ta.t) + ", but got " + std::to_string(b) + " at " + std::to_string(tb.t);
    }
  }
  return {};
}

/// The packets' picture equals brute force's and single rays' bit for bit, and Embree's but for rounding.
void expectAllAgree(std::span<const Sphere> cloud, const Camera& camera) {
  const TracedPicture brute = tracedPicture<BruteForceTracer>(cloud, camera);
  const TracedPicture packets = tracedPicture<LbvhTracer>(cloud, camera);
  EXPECT_EQ(packets.ids, brute.ids);
  EXPECT_EQ(packets.depth, brute.depth);
  Lbvh lbvh;
  lbvh.build(cloud);
  for (uint32_t y = 0; y < camera.height; ++y) {
    for (uint32_t x = 0; x < camera.width; ++x) {
      const LbvhHit hit = closestHit(lbvh.view(), pixelRay(camera, {x + 0.5f, y + 0.5f}));
      ASSERT_FALSE(hit.overflow);
      ASSERT_EQ(hit.id, brute.ids(x, y)) << x << "," << y;
      ASSERT_EQ(hit.t, brute.depth(x, y)) << x << "," << y;
    }
  }
  EXPECT_EQ(firstDifference(camera, cloud, brute, tracedPicture<EmbreeTracer>(cloud, camera)), "");
}

TEST(Case23, DenseLargeSpheresAreToldApart) {
  // What a sphere around a node leaves out must be nothing that a ray would have met first. A sphere covers 15 pixels of
  // 100 from afar, all from close by.
  for (const float scale : {1.0f, 0x1p-30f, 0x1p30f, 0x1p-50f, 3e15f}) {
    SCOPED_TRACE(scale);
    const auto cloud = makeCloud(CloudShape::dense, 2000, scale, 61);
    for (const float distance : {3.0f, 0.6f}) expectAllAgree(cloud, orbitCamera(distance * scale, 25.0f, 100, 75));
  }
}

TEST(Case55, TilesMaySeeHalfOfTheWorld) {
  // Pictures of few rows have wide pixels: the rays of one tile are up to 170 degrees apart.
  for (uint32_t seed = 0; seed < 60; ++seed) {
    SCOPED_TRACE(seed);
    const CloudShape shape = kCloudShapes[seed % kCloudShapes.size()];
    auto cloud = makeCloud(shape, 150, 1.0f, seed);
    for (Sphere& sphere : cloud) sphere.radius *= 4.0f;
    Camera camera = orbitCamera(0.3f + 0.05f * static_cast<float>(seed), 37.0f * static_cast<float>(seed), 3 + seed % 40, 1 + seed % 3);
    camera.tanHalfFovY = 0.8f;
    expectAllAgree(cloud, camera);
  }
}

TEST(Case19, EqualCodesAreToldApartByIndex) {
  const std::vector<Sphere> cloud(1000, Sphere{{1.0f, 2.0f, 3.0f}, 0.5f});
  Lbvh lbvh;
  lbvh.build(cloud);
  EXPECT_LE(checkStructure(lbvh, cloud), 7u) << "125 leaves of 8 make a balanced tree";
  const TracedPicture seen = tracedPicture<LbvhTracer>(cloud, orbitCamera(20.0f, 30.0f, 33, 21));
  for (const uint32_t id : seen.ids) EXPECT_TRUE(id == 0 || id == kNoSample) << "the lowest id wins";
  recordExact("Lbvh of 1000 identical spheres: nodes, boxes, depth", "Karras 2012");
}

TEST(Case19, NestedCodesStayWithinTheStack) {
  // Every bit of the code splits off one sphere, then the indices of equal ones.
  std::vector<Sphere> cloud;
  for (int bit = 0; bit < 21; ++bit)
    for (int axis = 0; axis < 3; ++axis) {
      glm::vec3 center(0.0f);
      center[axis] = std::ldexp(1.0f, bit);
      cloud.push_back({center, 1.0f});
    }
  cloud.push_back({glm::vec3(2097151.0f), 1.0f});
  cloud.resize(cloud.size() + 4096, Sphere{glm::vec3(0.0f), 1.0f});
  Lbvh lbvh;
  lbvh.build(cloud);
  EXPECT_GT(checkStructure(lbvh, cloud), 60u);
  expectAllAgree(cloud, orbitCamera(64.0f, 10.0f, 16, 16));
  recordExact("Lbvh of nested codes: the picture", "brute force");
}

TEST(Case20, HoldsNoneOneAndTwoSpheres) {
  const std::vector<Sphere> cloud{{{0.0f, 0.0f, 0.0f}, 1.0f}, {{1.0f, 0.0f, 0.5f}, 1.0f}};
  for (size_t count = 0; count <= 2; ++count) {
    SCOPED_TRACE(count);
    Lbvh lbvh;
    lbvh.build(std::span(cloud).first(count));
    EXPECT_EQ(lbvh.view().count, count);
    checkStructure(lbvh, std::span(cloud).first(count));
    expectAllAgree(std::span(cloud).first(count), orbitCamera(6.0f, 15.0f, 37, 23));
  }
  recordExact("Lbvh of 0, 1, 2 spheres: the picture", "brute force");
}

TEST(Case07, RefusesWhatCannotBeTraced) {
  const std::vector<Sphere> good(3, Sphere{glm::vec3(0.0f), 1.0f});
  const float inf = std::numeric_limits<float>::infinity(), nan = std::nanf("");
  std::vector<Sphere> bad;
  for (const float radius : {0.0f, -1.0f, nan, inf, 2e18f}) bad.push_back({glm::vec3(0.0f), radius});
  for (const float coordinate : {nan, inf, -inf, 2e18f})
    for (int axis = 0; axis < 3; ++axis) {
      bad.push_back({glm::vec3(0.0f), 1.0f});
      bad.back().center[axis] = coordinate;
    }
  for (const Sphere& sphere : bad) {
    std::vector<Sphere> cloud = good;
    cloud[1] = cloud[2] = sphere;
    LbvhTracer lbvh;
    EmbreeTracer embree;
    BruteForceTracer brute;
    for (SphereTracer* tracer : std::initializer_list<SphereTracer*>{&lbvh, &embree, &brute}) {
      tracer->build(good);
      try {
        tracer->build(cloud);
        ADD_FAILURE() << "accepted radius " << sphere.radius;
      } catch (const InputError& error) {
        EXPECT_NE(std::string(error.what()).find("sphere 1 "), std::string::npos) << error.what();
      }
      Image<uint32_t> ids;
      tracer->trace(orbitCamera(5.0f, 0.0f, 8, 8), ids, nullptr, {});
      EXPECT_EQ(ids, Image<uint32_t>(8, 8, kNoSample)) << "nothing is left of the last cloud";
    }
  }
  recordExact("SphereTracer::build refuses negative, NaN and infinite radii", "definition");
}

TEST(Case21, CodesOfFlatClouds) {
  const Box flat{{-1.0f, 2.0f, 3.0f}, {1.0f, 2.0f, 3.0f}};
  EXPECT_EQ(mortonCodeOf({1.0f, 2.0f, 3.0f}, flat), mortonCode(0x1fffff, 0, 0));
  EXPECT_EQ(mortonCodeOf({-1.0f, 2.0f, 3.0f}, flat), 0u);
  EXPECT_EQ(mortonCodeOf(glm::vec3(5.0f), {glm::vec3(5.0f), glm::vec3(5.0f)}), 0u);
  recordExact("mortonCodeOf without extent", "closed form");
}

TEST(Case22, CodesOfTheMaximum) {
  const Box cube{glm::vec3(-1.0f), glm::vec3(1.0f)};
  EXPECT_EQ(mortonCodeOf(glm::vec3(1.0f), cube), 0x7fffffffffffffffull);
  const Box huge{glm::vec3(-3e38f), glm::vec3(3e38f)};
  EXPECT_EQ(mortonCodeOf(glm::vec3(3e38f), huge), 0x7fffffffffffffffull);
  EXPECT_EQ(mortonCodeOf(glm::vec3(0.0f), huge), mortonCode(1u << 20, 1u << 20, 1u << 20));
  recordExact("mortonCodeOf at the bounds' maximum", "closed form");
}

TEST(Case23, OneSphereLargerThanAllTogether) {
  std::vector<Sphere> cloud = makeCloud(CloudShape::random, 2000, 1.0f, 23);
  cloud.insert(cloud.begin() + 1000, Sphere{{0.0f, 0.0f, -1e4f}, 9998.5f});
  Lbvh lbvh;
  lbvh.build(cloud);
  checkStructure(lbvh, cloud);
  expectAllAgree(cloud, orbitCamera(3.0f, 40.0f, 96, 64));
  recordExact("Lbvh, one sphere larger than all: the picture", "brute force");
}

TEST(Case24, TenMillionSpheres) {
  const std::vector<Sphere> cloud = makeCloud(CloudShape::random, 10'000'000, 1000.0f, 24);
  LbvhTracer lbvh;
  lbvh.build(cloud);
  // Fewer rays than pixels of a tile: brute force looks at every sphere for each.
  const Camera camera = orbitCamera(3000.0f, 5.0f, 5, 3);
  BruteForceTracer brute;
  brute.build(cloud);
  Image<uint32_t> ids, expected;
  lbvh.trace(camera, ids, nullptr, {});
  brute.trace(camera, expected, nullptr, {});
  EXPECT_EQ(ids, expected);
  EXPECT_TRUE(std::any_of(ids.begin(), ids.end(), [](uint32_t id) { return id != kNoSample; }));
  recordExact("Lbvh of 1e7 spheres: the picture", "brute force");
}

TEST(Case25, PropertyAllTracersAgreeOnAllClouds) {
  checkProperty([] {
    const CloudCase c = *anyCloudCase();
    expectAllAgree(c.cloud(), c.camera);
  });
  recordExact("packets, single rays, Embree on random, planar, collinear, clustered, equal spheres", "brute force");
}

TEST(Case11, AgreesFarFromTheCoordinatesOrigin) {
  auto cloud = makeCloud(CloudShape::clustered, 500, 100.0f, 11);
  Camera camera = orbitCamera(300.0f, 70.0f, 61, 47);
  for (Sphere& sphere : cloud) sphere.center += glm::vec3(1e7f, -1e7f, 1e7f);
  camera.eye += glm::vec3(1e7f, -1e7f, 1e7f);
  const TracedPicture brute = tracedPicture<BruteForceTracer>(cloud, camera);
  const TracedPicture packets = tracedPicture<LbvhTracer>(cloud, camera);
  EXPECT_EQ(packets.ids, brute.ids);
  EXPECT_EQ(packets.depth, brute.depth);
  recordExact("Lbvh at 1e7: the picture", "brute force");
}

TEST(Case12, IsTheSameForAnyNumberOfThreads) {
  const std::vector<Sphere> cloud = makeCloudOfTies();
  const Camera camera = orbitCamera(30.0f, 33.0f, 128, 96);
  Lbvh expected;
  TracedPicture expectedPicture;
  for (const size_t threads : {1, 2, 7}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    Lbvh lbvh;
    lbvh.build(cloud);
    const TracedPicture seen = tracedPicture<LbvhTracer>(cloud, camera);
    if (threads == 1) {
      expected = std::move(lbvh);
      expectedPicture = seen;
      continue;
    }
    const GroupedLbvhView a = expected.view(), b = lbvh.view();
    ASSERT_EQ(a.leaves, b.leaves);
    EXPECT_EQ(std::memcmp(a.nodes, b.nodes, (a.leaves - 1) * sizeof(LbvhNode)), 0);
    EXPECT_EQ(std::memcmp(a.leafFirst, b.leafFirst, (a.leaves + 1) * sizeof(uint32_t)), 0);
    EXPECT_EQ(std::memcmp(a.ids, b.ids, a.count * sizeof(uint32_t)), 0);
    EXPECT_EQ(seen.ids, expectedPicture.ids);
    EXPECT_EQ(seen.depth, expectedPicture.depth);
  }
  recordExact("Lbvh by 1, 2 and 7 threads", "itself");
}

// --- Techniques, on either backend: every pixel shows the sample that brute force finds.

/// What draws samples as spheres, on a backend.
std::vector<std::pair<std::string, WarpSettings>> sphereTechniques(Backend backend) {
  std::vector<std::pair<std::string, WarpSettings>> all{{"spheres", {}}, {"splats", {}}};
  for (const SphereTracing tracing : {SphereTracing::lbvh, SphereTracing::footprints, SphereTracing::clusters}) {
    if (tracing == SphereTracing::clusters && backend != Backend::cuda) continue;
    all.push_back({"spheres", {}});
    all.back().second.knobs.set(kSphereTracingKnob, tracing);
  }
  return all;
}

/// Returns the picture: each pixel's sample. The cloud is that of the frame, which quantises it.
Image<uint32_t> expectBruteForce(Backend backend, const std::vector<Sphere>& cloud, const Camera& camera) {
  auto frame = std::make_shared<SampleFrame>(frameOfCloud(cloud));
  std::vector<Sphere> spheres;
  for (size_t i = 0; i < frame->size(); ++i) {
    frame->colors[i] = 0xff000000u | static_cast<uint32_t>(i * 2654435761u >> 8);
    spheres.push_back(sphereOf(*frame, i));
  }
  const TracedPicture truth = tracedPicture<BruteForceTracer>(spheres, camera);
  for (const auto& [name, settings] : sphereTechniques(backend)) {
    const std::unique_ptr<Warp> warp = techniqueOn(backend, name);
    warp->setFrame(frame, settings);
    WarpedImage image;
    warp->draw(camera, settings, image);
    EXPECT_TRUE(image.samples == truth.ids) << name;
  }
  return truth.ids;
}

size_t covered(const Image<uint32_t>& ids) {
  return ids.size() - static_cast<size_t>(std::count(ids.begin(), ids.end(), kNoSample));
}

TEST_P(Case12, OfIdenticalSpheresTheLowestIdWins) {
  const std::vector<Sphere> cloud(1000, Sphere{glm::vec3(0.0f), 1.0f});
  for (const size_t threads : {1, 2, 5}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    const Image<uint32_t> ids = expectBruteForce(GetParam(), cloud, orbitCamera(8.0f, 30.0f, 61, 47));
    EXPECT_GT(covered(ids), 100u);
    for (const uint32_t id : ids) EXPECT_TRUE(id == 0 || id == kNoSample);
  }
  recordExact("techniques that draw spheres, of identical ones", "brute force", GetParam());
}

TEST_P(Case19, IdenticalAndNestedCodes) {
  std::vector<Sphere> cloud(500, Sphere{{1.0f, 2.0f, 3.0f}, 0.5f});
  for (int bit = 0; bit < 14; ++bit)
    for (int axis = 0; axis < 3; ++axis) {
      glm::vec3 center(0.0f);
      center[axis] = std::ldexp(1.0f, bit - 9);
      cloud.push_back({center, 0.25f});
    }
  EXPECT_GT(covered(expectBruteForce(GetParam(), cloud, orbitCamera(40.0f, 10.0f, 97, 65))), 20u);
  recordExact("techniques that draw spheres, equal and nested codes", "brute force", GetParam());
}

TEST_P(Case20, NoneOneAndTwoSpheres) {
  const std::vector<Sphere> cloud{{{0.0f, 0.0f, 0.0f}, 1.0f}, {{1.0f, 0.0f, 0.5f}, 1.0f}};
  for (size_t count = 0; count <= 2; ++count)
    EXPECT_EQ(covered(expectBruteForce(GetParam(), {cloud.begin(), cloud.begin() + static_cast<ptrdiff_t>(count)},
                                       orbitCamera(6.0f, 15.0f, 37, 23))) > 0,
              count > 0);
  recordExact("techniques that draw spheres, of 0, 1, 2", "brute force", GetParam());
}

TEST_P(Case21, FlatAndLineClouds) {
  for (const CloudShape shape : {CloudShape::planar, CloudShape::collinear})
    EXPECT_GT(
        covered(expectBruteForce(GetParam(), makeCloud(shape, 700, 10.0f, 21), orbitCamera(30.0f, 50.0f, 97, 65))),
        20u);
  recordExact("techniques that draw spheres, on a plane and on a line", "brute force", GetParam());
}

TEST_P(Case22, PositionsOnTheBoundsMaximum) {
  std::vector<Sphere> cloud;
  for (int corner = 0; corner < 8; ++corner)
    cloud.push_back({{corner & 1 ? 8.0f : -8.0f, corner & 2 ? 8.0f : -8.0f, corner & 4 ? 8.0f : -8.0f}, 1.0f});
  EXPECT_GT(covered(expectBruteForce(GetParam(), cloud, orbitCamera(60.0f, 33.0f, 97, 65))), 8u);
  recordExact("techniques that draw spheres, at the bounds' corners", "brute force", GetParam());
}

TEST_P(Case23, ASphereLargerThanTheScene) {
  std::vector<Sphere> cloud = makeCloud(CloudShape::random, 2000, 1.0f, 23);
  cloud.insert(cloud.begin() + 1000, Sphere{{0.0f, 0.0f, -300.0f}, 298.5f});
  EXPECT_GT(covered(expectBruteForce(GetParam(), cloud, orbitCamera(3.0f, 40.0f, 96, 64))), 500u);
  recordExact("techniques that draw spheres, one larger than all", "brute force", GetParam());
}

/// On the CPU the test of the hierarchy itself, above, has as many.
class Case24 : public OnBackend {};
INSTANTIATE_TEST_SUITE_P(On, Case24, testing::Values(Backend::cuda),
                         [](const auto& backend) { return std::string(nameOf(backend.param)); });

TEST_P(Case24, TenMillionSamples) {
  expectBruteForce(GetParam(), makeCloud(CloudShape::random, 10'000'000, 1000.0f, 24),
                   orbitCamera(3000.0f, 5.0f, 5, 3));
  recordExact("Lbvh of 1e7 spheres: the picture", "brute force", GetParam());
}

TEST_P(Case25, PropertyTechniquesFindWhatBruteForceFinds) {
  checkProperty([&] {
    const CloudCase c = *anyCloudCase();
    expectBruteForce(GetParam(), c.cloud(), c.camera);
  });
  recordExact("techniques that draw spheres, on random, planar, collinear, clustered, equal ones", "brute force",
              GetParam());
}

}  // namespace
}  // namespace warpscope
