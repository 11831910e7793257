// Rays against spheres, grazing, from inside, far away, of no radius, judged by an oracle of 100 decimal digits.
// Near tangency, where the inputs' own rounding decides, either answer is right; everywhere else only one is.
#include "render/core/ray_sphere.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <boost/multiprecision/cpp_bin_float.hpp>
#include <random>

#include "render/warp/lbvh/ray_packet.h"

namespace warpscope {
namespace {

using Exact = boost::multiprecision::cpp_bin_float_100;

constexpr double kUnitRoundoff = 1.0 / 16777216.0;

struct ExactVec {
  Exact x, y, z;
  explicit ExactVec(const glm::vec3& v) : x(v.x), y(v.y), z(v.z) {}
  ExactVec(Exact px, Exact py, Exact pz) : x(px), y(py), z(pz) {}
  ExactVec operator-(const ExactVec& o) const { return {x - o.x, y - o.y, z - o.z}; }
  ExactVec operator*(const Exact& s) const { return {x * s, y * s, z * s}; }
};
Exact dot(const ExactVec& a, const ExactVec& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

enum class Verdict { hit, miss, undecided };

struct Truth {
  Verdict verdict;
  Exact tolerance;  // what rounding may do to a distance
};

/// As large as the sphere is seen.
Exact seenFrom(const Ray& ray, const glm::vec3& center, float radius) {
  const ExactVec toCenter = ExactVec(center) - ExactVec(ray.origin);
  const Exact half = sqrt(dot(toCenter, toCenter)) / 2;
  return half < radius ? half : Exact(radius);
}

/// What intersectSphere has to answer. It is undecided where the ray passes the surface, or starts from it, within
/// rounding.
Truth judge(const Ray& ray, const glm::vec3& center, float wholeRadius) {
  const Exact radius = seenFrom(ray, center, wholeRadius);
  const ExactVec toCenter = ExactVec(center) - ExactVec(ray.origin);
  const ExactVec direction(ray.direction);
  const ExactVec unit = direction * (1 / sqrt(dot(direction, direction)));
  const Exact along = dot(toCenter, unit);
  const ExactVec offset = toCenter - unit * along;
  const Exact distance = sqrt(dot(toCenter, toCenter));
  const Exact beside = sqrt(dot(offset, offset));
  const Exact tolerance = 8 * kUnitRoundoff * (distance + radius);
  if (abs(beside - radius) <= tolerance || abs(distance - radius) <= tolerance || abs(along) <= tolerance)
    return {Verdict::undecided, tolerance};
  const bool hit = beside < radius && distance > radius && along > 0;
  return {hit ? Verdict::hit : Verdict::miss, tolerance};
}

/// How far the point at `t` is from the sphere's surface.
Exact distanceFromSurface(const Ray& ray, float t, const glm::vec3& center, float radius) {
  const ExactVec direction(ray.direction);
  const ExactVec unit = direction * (1 / sqrt(dot(direction, direction)));
  const ExactVec offset = ExactVec(center) - ExactVec(ray.origin) - unit * Exact(t);
  return abs(sqrt(dot(offset, offset)) - seenFrom(ray, center, radius));
}

float hitAlongZ(float offset, float distance, float radius) {
  return intersectSphere({{offset, 0.0f, 0.0f}, {0.0f, 0.0f, 1.0f}}, {0.0f, 0.0f, distance}, radius);
}

const Ray kAlongZ{{0.0f, 0.0f, 0.0f}, {0.0f, 0.0f, 1.0f}};

TEST(RaySphere, FarSphereIsHitInsideItsOutlineAndMissedOutside) {
  EXPECT_NEAR(hitAlongZ(0.5f, 1e4f, 1.0f), 1e4 - std::sqrt(0.75), 2e-3);
  EXPECT_EQ(hitAlongZ(1.001f, 1e4f, 1.0f), kNoHit);
}

TEST(RaySphere, TangentHasOneDistance) { EXPECT_EQ(hitAlongZ(1.0f, 8.0f, 1.0f), 8.0f); }

TEST(RaySphere, AnEyeInsideSeesTheSphereHalfwayToItsCentre) {
  EXPECT_EQ(hitAlongZ(0.0f, 0.5f, 1.0f), 0.25f);
  EXPECT_EQ(hitAlongZ(0.0f, 1.0f, 1.0f), 0.5f);    // on its surface
  EXPECT_FLOAT_EQ(hitAlongZ(0.0f, 1.9f, 1.0f), 0.95f); // and near it
  EXPECT_EQ(hitAlongZ(0.0f, 2.0f, 1.0f), 1.0f);
  EXPECT_EQ(hitAlongZ(0.0f, 0.0f, 1.0f), kNoHit);  // there is no direction to see it in
  EXPECT_EQ(hitAlongZ(0.0f, -0.5f, 1.0f), kNoHit);
  EXPECT_EQ(hitAlongZ(0.0f, -1.0f, 1.0f), kNoHit);
  EXPECT_EQ(hitAlongZ(1.0f, 0.0f, 1.0f), kNoHit);
  // 30 degrees around its centre and no more.
  for (const float degrees : {0.0f, 15.0f, 29.9f, 30.1f, 60.0f}) {
    const float angle = glm::radians(degrees);
    const float t = intersectSphere({{0.0f, 0.0f, 0.0f}, {std::sin(angle), 0.0f, std::cos(angle)}}, {0.0f, 0.0f, 0.01f}, 1.0f);
    EXPECT_EQ(t < kNoHit, degrees < 30.0f) << degrees;
  }
}

TEST(RaySphere, GrazingHitsStayBeforeTheClosestPoint) {
  std::mt19937 random(5);
  std::uniform_real_distribution<float> unit(-1.0f, 1.0f);
  for (int i = 0; i < 100000; ++i) {
    // Directions along the outline of what is seen but for a little, from any distance.
    const glm::vec3 normal = glm::normalize(glm::vec3(unit(random), unit(random), unit(random)));
    const glm::vec3 side = glm::normalize(glm::cross(normal, glm::vec3(unit(random), unit(random), unit(random))));
    const float distance = std::exp2(8.0f * std::abs(unit(random)));
    const float sine = std::min(0.5f, 1.0f / distance) * (1.0f + std::ldexp(unit(random), -static_cast<int>(random() % 24)));
    const Ray ray{-distance * normal, glm::normalize(std::sqrt(1.0f - sine * sine) * normal + sine * side)};
    const float t = intersectSphere(ray, glm::vec3(0.0f), 1.0f);
    if (t == kNoHit) continue;
    ASSERT_LE(t, glm::dot(-ray.origin, ray.direction)) << "seed 5, ray " << i;
  }
}

TEST(RaySphere, NoRadiusNoHit) {
  for (const float radius : {0.0f, -0.0f, -1.0f, std::nanf(""), -kNoHit})
    EXPECT_EQ(intersectSphere(kAlongZ, {0.0f, 0.0f, 5.0f}, radius), kNoHit) << radius;
}

TEST(RaySphere, BehindIsMissed) { EXPECT_EQ(hitAlongZ(0.0f, -5.0f, 1.0f), kNoHit); }

TEST(RaySphere, FarFromTheCoordinatesOrigin) {
  const Ray ray{{1e7f, 0.0f, 0.0f}, {0.0f, 0.0f, 1.0f}};
  EXPECT_EQ(intersectSphere(ray, {1e7f, 0.0f, 16.0f}, 4.0f), 12.0f);
  EXPECT_EQ(intersectSphere(ray, {1e7f + 8.0f, 0.0f, 16.0f}, 4.0f), kNoHit);
}

/// A ray that passes a sphere of any size at any distance, most of them near its outline.
struct Case {
  Ray ray;
  glm::vec3 center;
  float radius;
};

Case makeCase(uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> unit(-1.0f, 1.0f);
  const auto direction = [&] { return glm::normalize(glm::vec3(unit(random), unit(random), unit(random) + 1e-3f)); };
  const glm::vec3 forward = direction();
  const float radius = std::pow(10.0f, 3.0f * unit(random));
  const float distance = radius * std::pow(10.0f, 2.5f + 2.5f * unit(random));
  const float grazing = 1.0f + std::ldexp(unit(random), -static_cast<int>(random() % 24));
  const glm::vec3 origin = distance * std::pow(10.0f, unit(random)) * direction();
  const glm::vec3 side = glm::normalize(glm::cross(forward, direction()));
  return {{origin, forward}, origin + distance * forward + grazing * radius * side, radius};
}

RC_GTEST_PROP(RaySphere, AgreesWithTheOracleWhereverThatIsSure, (uint32_t seed)) {
  for (uint32_t i = 0; i < 200; ++i) {
    const Case c = makeCase(seed + i);
    const float t = intersectSphere(c.ray, c.center, c.radius);
    RC_ASSERT(t >= 0.0f);  // and not NaN
    const Truth truth = judge(c.ray, c.center, c.radius);
    if (truth.verdict != Verdict::undecided) {
      RC_ASSERT((t < kNoHit) == (truth.verdict == Verdict::hit));
    }
    if (t < kNoHit) {
      RC_ASSERT(distanceFromSurface(c.ray, t, c.center, c.radius) <= 2 * truth.tolerance);
    }
  }
}

RC_GTEST_PROP(RaySphere, ScalingByPowersOfTwoScalesTheDistance, (uint32_t seed)) {
  const Case c = makeCase(seed);
  const float t = intersectSphere(c.ray, c.center, c.radius);
  for (const float scale : {0.0009765625f, 0.5f, 1024.0f})
    RC_ASSERT(intersectSphere({scale * c.ray.origin, c.ray.direction}, scale * c.center, scale * c.radius) ==
              scale * t);
}

RC_GTEST_PROP(RayPacket, HoldsTheSameBitsAsOneRay, (uint32_t seed)) {
  for (uint32_t i = 0; i < 200; ++i) {
    const Case c = makeCase(seed + i);
    const glm::vec3& d = c.ray.direction;
    const FloatPack t = intersectSpherePack(Vec3Pack{FloatPack(d.x), FloatPack(d.y), FloatPack(d.z)},
                                            c.center - c.ray.origin, c.radius);
    RC_ASSERT(t.get(seed % kPackLanes) == intersectSphere(c.ray, c.center, c.radius));
  }
}

RC_GTEST_PROP(RayPacket, PixelsHaveTheSameDirections, (uint16_t tilt)) {
  Camera camera;
  const float angle = 1e-4f * tilt;
  camera.forward = {std::sin(angle), 0.0f, -std::cos(angle)};
  camera.right = {std::cos(angle), 0.0f, std::sin(angle)};
  camera.width = 1023;
  camera.height = 77;
  for (uint32_t x = 0; x < camera.width; x += kPackLanes) {
    const Vec3Pack pack = pixelDirections(camera, static_cast<float>(x) + laneNumbers() + 0.5f, FloatPack(13.5f));
    for (uint32_t lane = 0; lane < kPackLanes; ++lane) {
      const glm::vec3 expected = pixelRay(camera, {x + lane + 0.5f, 13.5f}).direction;
      RC_ASSERT(glm::vec3(pack.x.get(lane), pack.y.get(lane), pack.z.get(lane)) == expected);
    }
  }
}

TEST(RayPacket, LargestLane) {
  const FloatPack numbers = laneNumbers();
  EXPECT_EQ(largestLane(numbers), static_cast<float>(kPackLanes - 1));
  EXPECT_EQ(largestLane(-numbers - 1.0f), -1.0f);
  EXPECT_EQ(largestLane(xsimd::select(numbers == FloatPack(1.0f), FloatPack(kNoHit), numbers)), kNoHit);
}

TEST(RayPacket, NearerHitsComeFirstAndOfEqualOnesTheLowerId) {
  const auto bits = [](float t, int id, float bestT, int bestId) {
    return laneBits(isNearer({FloatPack(t), IntPack(id)}, {FloatPack(bestT), IntPack(bestId)}));
  };
  const uint32_t all = laneBits(laneNumbers() >= FloatPack(0.0f));
  EXPECT_EQ(bits(1.0f, 9, 2.0f, 3), all);
  EXPECT_EQ(bits(2.0f, 2, 2.0f, 3), all);
  EXPECT_EQ(bits(2.0f, 3, 2.0f, 3), 0u);
  EXPECT_EQ(bits(3.0f, 2, 2.0f, 3), 0u);
  EXPECT_EQ(bits(3.0f, 2, kNoHit, -1), all);
  EXPECT_EQ(bits(kNoHit, 2, kNoHit, 3), 0u) << "no hit is none, whatever its id";
}

TEST(RayPacket, LaneBitsNameTheLanes) {
  for (uint32_t lane = 0; lane < kPackLanes; ++lane)
    EXPECT_EQ(laneBits(laneNumbers() == FloatPack(static_cast<float>(lane))), 1u << lane);
  EXPECT_EQ(laneBits(laneNumbers() < FloatPack(0.0f)), 0u);
}

}  // namespace
}  // namespace warpscope
