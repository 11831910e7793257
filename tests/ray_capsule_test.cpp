// Rays and capsules against distances from the line, in long double; without a length against spheres, and in packets against one ray, bit for bit.
// Mirrors render/core/ray_capsule.h, the capsules of render/warp/lbvh/ (lbvh.h, ray_packet.h, tile_tracer.h) and render/warp/lbvh/sample_capsules.h.
#include "render/core/ray_capsule.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>
#include <limits>

#include "render/warp/lbvh/ray_packet.h"
#include "render/warp/lbvh/sample_capsules.h"
#include "render/warp/lbvh/sphere_tracer.h"
#include "tests/frame_samples.h"
#include "tests/sphere_clouds.h"
#include "tests/stability/magnitudes.h"

namespace warpscope {
namespace {

struct CapsuleCase {
  Ray ray;
  glm::vec3 center, half;
  float radius;
};

void showValue(const CapsuleCase& c, std::ostream& out) {
  showBits(out << "eye ", c.ray.origin);
  showBits(out << ", direction ", c.ray.direction);
  showBits(out << ", centre ", c.center);
  showBits(out << ", half ", c.half) << ", radius " << std::hexfloat << c.radius << std::defaultfloat;
}

/// Rays that pass near the outline of spheres, drawn out in any direction, many of them nearly along the ray; ends beside the point that the ray passes.
rc::Gen<CapsuleCase> anyCapsuleCase() {
  return rc::gen::map(rc::gen::tuple(anySphereCase(-20, 20), anyDirection(), anyInteger(-26, 2), anyInteger(-8, 10), anyInteger(-80, 80)), [](const auto& parts) {
    const auto& [sphere, tilt, tilted, length, place] = parts;
    const glm::vec3 line = glm::normalize(sphere.ray.direction + std::ldexp(1.0f, tilted) * tilt + 1e-30f);
    const glm::vec3 half = std::ldexp(sphere.radius, length) * line;
    return CapsuleCase{sphere.ray, sphere.center - static_cast<float>(place) / 64.0f * half, half, sphere.radius};
  });
}

using Real = long double;
struct RealVec {
  Real x, y, z;
  RealVec(Real a, Real b, Real c) : x(a), y(b), z(c) {}
  RealVec(const glm::vec3& v) : x(v.x), y(v.y), z(v.z) {}
};
RealVec operator+(const RealVec& a, const RealVec& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
RealVec operator-(const RealVec& a, const RealVec& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
RealVec operator*(Real s, const RealVec& v) { return {s * v.x, s * v.y, s * v.z}; }
Real dot(const RealVec& a, const RealVec& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

struct Truth {
  RealVec toCenter, half, direction;
  Real radius = 0.0L;  ///< as it is seen
  Real scale = 0.0L;

  explicit Truth(const CapsuleCase& c) : toCenter(RealVec(c.center) - RealVec(c.ray.origin)), half(c.half), direction(c.ray.direction) {
    direction = (1.0L / std::sqrt(dot(direction, direction))) * direction;
    radius = std::min<Real>(c.radius, 0.5L * fromLine({0.0L, 0.0L, 0.0L}));
    scale = std::sqrt(dot(toCenter, toCenter)) + std::sqrt(dot(half, half)) + c.radius;
  }
  Real fromLine(const RealVec& point) const {
    const Real length = dot(half, half);
    const Real s = length > 0.0L ? std::clamp(dot(point - toCenter, half) / length, -1.0L, 1.0L) : 0.0L;
    const RealVec offset = point - (toCenter + s * half);
    return std::sqrt(dot(offset, offset));
  }
  Real at(Real t) const { return fromLine(t * direction); }
  /// Where the ray comes nearest to the line: the distance is convex along it.
  Real nearest() const {
    Real low = 0.0L, high = 4.0L * scale;
    for (int i = 0; i < 200; ++i) {
      const Real a = low + (high - low) / 3.0L, b = high - (high - low) / 3.0L;
      (at(a) < at(b) ? high : low) = at(a) < at(b) ? b : a;
    }
    return low;
  }
};

TEST(RayCapsule, PropertyIsWhereTheRayFirstComesAsNearToTheLineAsTheRadius) {
  checkProperty([] {
    const CapsuleCase c = *anyCapsuleCase();
    const float t = intersectCapsule(c.ray, c.center, c.half, c.radius);
    RC_ASSERT(t >= 0.0f);  // and not NaN
    const Truth truth(c);
    const Real allowed = static_cast<Real>(kCapsuleSurfaceError) * truth.scale, nearest = truth.nearest();
    if (truth.at(nearest) > truth.radius + allowed) RC_ASSERT(t == kNoHit);
    if (truth.at(nearest) < truth.radius - allowed) RC_ASSERT(t < kNoHit);
    if (t == kNoHit) return;
    RC_ASSERT(std::abs(truth.at(static_cast<Real>(t)) - truth.radius) <= allowed);
    // It is where the ray enters, not where it leaves.
    if (truth.at(nearest) < truth.radius - allowed) RC_ASSERT(static_cast<Real>(t) <= nearest * (1.0L + 0x1p-22L));
  });
}

TEST(RayCapsule, PropertyWithoutALengthItIsTheSphere) {
  checkProperty([] {
    const SphereCase c = *anySphereCase(-40, 40);
    RC_ASSERT(intersectCapsule(c.ray, c.center, glm::vec3(0.0f), c.radius) == intersectSphere(c.ray, c.center, c.radius));
  });
}

TEST(RayCapsule, PropertyPacketsHoldTheSameBits) {
  checkProperty([] {
    const CapsuleCase c = *anyCapsuleCase();
    const glm::vec3 toCenter = c.center - c.ray.origin;
    const glm::vec3& d = c.ray.direction;
    const FloatPack t = intersectCapsulePack(Vec3Pack{FloatPack(d.x), FloatPack(d.y), FloatPack(d.z)}, toCenter, seenCapsule(toCenter, c.half, c.radius));
    for (uint32_t lane = 0; lane < kPackLanes; ++lane) RC_ASSERT(t.get(lane) == intersectCapsule(c.ray, c.center, c.half, c.radius));
  });
}

TEST(RayCapsule, AlongItsLineAcrossItAndBesideIt) {
  const Ray ray{glm::vec3(0.0f), {0.0f, 0.0f, 1.0f}};
  EXPECT_EQ(intersectCapsule(ray, {0.0f, 0.0f, 10.0f}, {0.0f, 0.0f, 3.0f}, 1.0f), 6.0f);
  EXPECT_EQ(intersectCapsule(ray, {0.0f, 0.0f, 10.0f}, {0.0f, 0.0f, -3.0f}, 1.0f), 6.0f);
  EXPECT_EQ(intersectCapsule(ray, {2.0f, 0.0f, 10.0f}, {3.0f, 0.0f, 0.0f}, 1.0f), 9.0f);
  EXPECT_EQ(intersectCapsule(ray, {5.0f, 0.0f, 10.0f}, {3.0f, 0.0f, 0.0f}, 1.0f), kNoHit);
  EXPECT_EQ(intersectCapsule(ray, {0.0f, 2.0f, 10.0f}, {0.0f, 0.0f, 3.0f}, 1.0f), kNoHit);
  EXPECT_EQ(intersectCapsule(ray, {0.0f, 0.0f, -10.0f}, {0.0f, 0.0f, 3.0f}, 1.0f), kNoHit);
  EXPECT_EQ(intersectCapsule(ray, {0.0f, 0.0f, 10.0f}, {0.0f, 0.0f, 3.0f}, 0.0f), kNoHit);
  EXPECT_EQ(intersectCapsule(ray, {0.0f, 0.0f, 1.0f}, {0.0f, 0.0f, 3.0f}, 1.0f), kNoHit) << "an eye on the line sees past it";
}

/// Whole pictures of clouds of capsules of all lengths, 0 among them, against each ray with each capsule and against one ray through the hierarchy.
RC_GTEST_PROP(RayCapsule, TracedCloudsAreTheSearchedOnes, (uint32_t seed)) {
  std::mt19937 random(seed);
  const CloudShape shape = kCloudShapes[random() % kCloudShapes.size()];
  const std::vector<Sphere> cloud = makeCloud(shape, 1 + random() % 200, 10.0f, seed);
  std::uniform_real_distribution<float> unit(-1.0f, 1.0f);
  std::vector<glm::vec3> lines;
  for (size_t i = 0; i < cloud.size(); ++i) lines.push_back((random() % 3 == 0 ? 0.0f : 4.0f * unit(random)) * glm::vec3(unit(random), unit(random), unit(random)));
  LbvhTracer tracer;
  tracer.build(cloud, lines);
  const Camera camera = orbitCamera(random() % 2 == 0 ? 30.0f : 3.0f, static_cast<float>(random() % 360), 1 + random() % 40, 1 + random() % 30);
  Image<uint32_t> ids;
  Image<float> depth;
  tracer.trace(camera, ids, &depth, {});
  for (uint32_t y = 0; y < camera.height; ++y)
    for (uint32_t x = 0; x < camera.width; ++x) {
      const Ray ray = pixelRay(camera, {static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f});
      LbvhHit expected;
      for (uint32_t id = 0; id < cloud.size(); ++id) {
        const float t = intersectCapsule(ray, cloud[id].center, lines[id], cloud[id].radius);
        if (t < expected.t) expected = {t, id};
      }
      const LbvhHit single = closestHit<StableCapsule>(tracer.view(), ray);
      RC_ASSERT(!single.overflow);
      RC_ASSERT(single.id == expected.id);
      RC_ASSERT(ids(x, y) == expected.id);
      RC_ASSERT(depth(x, y) == expected.t);
    }
}

TEST(SampleCapsules, AreAsLongAsTheirSpreadsWithinBounds) {
  SampleFrame frame = frameOfSpheres({{{0.0f, 0.0f, 8.0f}, 1.0f}, {{4.0f, 0.0f, 0.0f}, 1.0f}, {{0.0f, 0.0f, -8.0f}, 1.0f}}, 1.0f, 1.0f, 63, 64.0f);
  const SampleGrid grid = frame.grid();
  for (size_t i = 0; i < frame.size(); ++i) {
    const auto lengthOf = [&](float spread, float factor) { return glm::length(halfLineOf(grid, frame.samples[i], spread, factor)); };
    EXPECT_NEAR(lengthOf(2.0f, 0.5f), 1.0f, 1e-5f);
    const glm::vec3 line = halfLineOf(grid, frame.samples[i], 2.0f, 1.0f);
    EXPECT_LT(glm::length(glm::cross(line, glm::normalize(sphereOf(frame, i).center - frame.camera.eye))), 1e-4f) << "along its ray";
    for (const float none : {0.0f, -1.0f, std::numeric_limits<float>::quiet_NaN()}) EXPECT_EQ(lengthOf(none, 1.0f), 0.0f);
    EXPECT_LE(lengthOf(std::numeric_limits<float>::infinity(), 1.0f), 1.0001f * glm::length(grid.bounds.extent()));
  }
}

}  // namespace
}  // namespace warpscope
