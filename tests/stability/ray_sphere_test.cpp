// Rays against spheres: cases 1 to 6 and 8 to 11. Verdicts by enclosures, distances by 100 decimal digits.
// Mirrors render/core/ray_sphere.h. Near tangency, where rounding decides, either answer is right; everywhere else only
// one is.
#include "render/core/ray_sphere.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

#include "tests/stability/backends.h"
#include "tests/stability/device_probe.h"
#include "tests/stability/exact.h"
#include "tests/stability/magnitudes.h"
#include "tests/stability/probes.h"
#include "tests/stability/record.h"

namespace warpscope {
namespace {

/// Lengths within which intersectSphere keeps its promises, as exponents of 2.
constexpr int kLeast = -50, kMost = 40;  // and up to 2^16 radii away

float hitAlongZ(Backend backend, float offset, float distance, float radius) {
  return evaluate<SphereProbe>(
      backend, SphereProbe::Input{{{offset, 0.0f, 0.0f}, {0.0f, 0.0f, 1.0f}}, {0.0f, 0.0f, distance}, radius});
}

SphereProbe::Input inputOf(const SphereCase& c) { return {c.ray, c.center, c.radius}; }

std::vector<SphereProbe::Input> inputsOf(const std::vector<SphereCase>& cases) {
  std::vector<SphereProbe::Input> inputs;
  for (const SphereCase& c : cases) inputs.push_back(inputOf(c));
  return inputs;
}

// --- What is certain of a ray and a sphere

using EnclosedVec = std::array<Enclosure, 3>;

Enclosure dot(const EnclosedVec& a, const EnclosedVec& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
Enclosure squared(const EnclosedVec& v) { return v[0].squared() + v[1].squared() + v[2].squared(); }

/// The formulas of ray_sphere.h, for directions that are unit up to their own rounding.
Verdict verdictOf(const SphereCase& c) {
  const auto component = [&](int axis) { return Enclosure(c.center[axis]) - Enclosure(c.ray.origin[axis]); };
  const EnclosedVec toCenter{component(0), component(1), component(2)};
  EnclosedVec direction{c.ray.direction.x, c.ray.direction.y, c.ray.direction.z};
  for (Enclosure& d : direction) d = d.widened(2.0);
  const Enclosure distance = squared(toCenter);
  const Enclosure half = Enclosure(0.5) * distance.root(), whole(c.radius);
  const Enclosure excess = Enclosure(4.0) * whole.squared() - distance;
  const Enclosure seen = excess.isPositive() ? half : excess.isNegative() ? whole : hull(half, whole);
  const Enclosure along = dot(toCenter, direction), outside = distance - seen.squared();
  EnclosedVec offset{0.0, 0.0, 0.0};
  for (size_t axis = 0; axis < 3; ++axis) offset[axis] = toCenter[axis] - along * direction[axis];
  const Enclosure discriminant = seen.squared() - squared(offset);
  if (along.isNegative() || outside.isNegative() || discriminant.isNegative()) return Verdict::miss;
  return along.isPositive() && outside.isPositive() && discriminant.isPositive() ? Verdict::hit : Verdict::undecided;
}

struct Truth {
  Exact scale;     ///< distance of the centre and radius
  Exact beside;    ///< of the ray from the centre
  Exact radius;    ///< as large as the sphere is seen
  Exact along;     ///< to the point that is nearest to the centre
  Exact distance;  ///< of the centre
  bool isHit() const { return along > 0 && beside <= radius; }
  Exact t() const { return along - sqrt(radius * radius - beside * beside); }
};

Truth truthOf(const SphereCase& c) {
  const ExactVec toCenter = ExactVec(c.center) - ExactVec(c.ray.origin), direction(c.ray.direction);
  const ExactVec unit = direction * (1 / length(direction));
  Truth truth;
  truth.distance = length(toCenter);
  truth.along = dot(toCenter, unit);
  truth.beside = length(toCenter - unit * truth.along);
  truth.radius = std::min<Exact>(truth.distance / 2, Exact(c.radius));
  truth.scale = truth.distance + truth.radius;
  return truth;
}

/// How far the point at `t` is from the sphere's surface, in roundoffs of distance and radius.
double surfaceError(const Truth& truth, float t) {
  const Exact before = truth.along - Exact(t);
  return roundoffs(sqrt(before * before + truth.beside * truth.beside), truth.radius, truth.scale);
}

TEST_P(Case01, AFarSphereIsHitInsideItsOutline) {
  Worst worst;
  for (const float offset : {0.0f, 0.5f, 0.9f, 0.99f}) {
    const SphereCase c{{{offset, 0.0f, 0.0f}, {0.0f, 0.0f, 1.0f}}, {0.0f, 0.0f, 1e4f}, 1.0f};
    const Truth truth = truthOf(c);
    worst.see(roundoffs(hitAlongZ(GetParam(), offset, 1e4f, 1.0f), truth.t(), truth.t()));
  }
  record({"intersectSphere, radius 1 at 1e4", "100 digits", "u of t", worst.value(),
          kSphereDistanceError / kUnitRoundoff, GetParam()});
}

TEST_P(Case01, PropertyPointsLieOnTheSurface) {
  Worst worst, ofT;
  checkProperty([&] {
    const auto cases = *rc::gen::container<std::vector<SphereCase>>(anySphereCase(kLeast, kMost));
    const std::vector<float> found = evaluate<SphereProbe>(GetParam(), inputsOf(cases));
    for (size_t i = 0; i < cases.size(); ++i) {
      RC_ASSERT(found[i] >= 0.0f);  // and not NaN
      const Verdict verdict = verdictOf(cases[i]);
      if (verdict != Verdict::undecided) RC_ASSERT((found[i] < kNoHit) == (verdict == Verdict::hit));
      const Truth truth = truthOf(cases[i]);
      if (verdict != Verdict::undecided) RC_ASSERT((verdict == Verdict::hit) == truth.isHit());
      if (!(found[i] < kNoHit)) continue;
      const double error = surfaceError(truth, found[i]);
      RC_ASSERT(error * kUnitRoundoff <= kSphereSurfaceError);
      worst.see(error);
      // Away from the outline, where the surface is not nearly parallel to the ray, the distance itself is as good.
      if (truth.beside > truth.radius / 2) continue;
      const double distanceError = roundoffs(found[i], truth.t(), truth.t());
      RC_ASSERT(distanceError * kUnitRoundoff <= kSphereDistanceError);
      ofT.see(distanceError);
    }
  });
  record({"intersectSphere, the point", "100 digits", "u of distance and radius", worst.value(),
          kSphereSurfaceError / kUnitRoundoff, GetParam()});
  record({"intersectSphere, inside half the outline", "100 digits", "u of t", ofT.value(),
          kSphereDistanceError / kUnitRoundoff, GetParam()});
}

TEST_P(Case01, PropertyNeverNotANumberWhateverTheMagnitude) {
  checkProperty([&] {
    std::vector<SphereProbe::Input> inputs;
    for (const auto& [origin, direction, center, radius] :
         *rc::gen::container<std::vector<std::tuple<glm::vec3, glm::vec3, glm::vec3, float>>>(
             rc::gen::tuple(anyVector(), anyDirection(), anyVector(), anyNumber())))
      inputs.push_back({{origin, direction}, center, radius});
    for (const float t : evaluate<SphereProbe>(GetParam(), inputs)) RC_ASSERT(t >= 0.0f);
  });
  recordExact("intersectSphere, never NaN from 1e-30 to 1e30", "IEEE 754", GetParam());
}

TEST_P(Case02, AFarSphereIsMissedBesideItsOutline) {
  for (const float offset : {1.001f, 1.01f, 2.0f, 100.0f})
    EXPECT_EQ(hitAlongZ(GetParam(), offset, 1e4f, 1.0f), kNoHit) << offset;
  recordExact("intersectSphere, radius 1 at 1e4, missed", "closed form", GetParam());
}

TEST_P(Case02, FewVerdictsAreUndecided) {
  // Or enclosures would excuse everything: at distance 100 with a radius of 0.01 the textbook's discriminant is wrong
  // in 63 % of these.
  std::mt19937 random(2);
  std::uniform_real_distribution<float> unit(-1.0f, 1.0f);
  std::vector<SphereCase> cases;
  for (int i = 0; i < 20000; ++i)
    cases.push_back(
        {{{0.01f * (1.0f + 0.1f * unit(random)), 0.0f, 0.0f}, {0.0f, 0.0f, 1.0f}}, {0.0f, 0.0f, 100.0f}, 0.01f});
  const std::vector<float> found = evaluate<SphereProbe>(GetParam(), inputsOf(cases));
  size_t undecided = 0, wrong = 0, hits = 0;
  for (size_t i = 0; i < cases.size(); ++i) {
    undecided += verdictOf(cases[i]) == Verdict::undecided;
    wrong += (found[i] < kNoHit) != truthOf(cases[i]).isHit();
    hits += found[i] < kNoHit;
  }
  EXPECT_LT(undecided, cases.size() / 50);
  EXPECT_GT(hits, cases.size() / 3);
  record({"intersectSphere, radius .01 at 100, within a tenth of the outline", "100 digits", "wrong verdicts",
          static_cast<double>(wrong), 0.0, GetParam()});
}

TEST_P(Case03, ATangentHasOneDistance) {
  EXPECT_EQ(hitAlongZ(GetParam(), 1.0f, 8.0f, 1.0f), 8.0f);
  EXPECT_EQ(hitAlongZ(GetParam(), -0.25f, 64.0f, 0.25f), 64.0f);
  recordExact("intersectSphere, tangent", "closed form", GetParam());
}

TEST_P(Case03, GrazingHitsStayBeforeTheClosestPoint) {
  std::mt19937 random(5);
  std::uniform_real_distribution<float> unit(-1.0f, 1.0f);
  std::vector<SphereProbe::Input> inputs;
  for (int i = 0; i < 100000; ++i) {
    // Directions along the outline of what is seen but for a little, from any distance.
    const glm::vec3 normal = glm::normalize(glm::vec3(unit(random), unit(random), unit(random)));
    const glm::vec3 side = glm::normalize(glm::cross(normal, glm::vec3(unit(random), unit(random), unit(random))));
    const float distance = std::exp2(8.0f * std::abs(unit(random)));
    const float sine =
        std::min(0.5f, 1.0f / distance) * (1.0f + std::ldexp(unit(random), -static_cast<int>(random() % 24)));
    inputs.push_back({{-distance * normal, glm::normalize(std::sqrt(1.0f - sine * sine) * normal + sine * side)},
                      glm::vec3(0.0f),
                      1.0f});
  }
  const std::vector<float> found = evaluate<SphereProbe>(GetParam(), inputs);
  size_t hits = 0;
  for (size_t i = 0; i < inputs.size(); ++i) {
    if (found[i] == kNoHit) continue;
    ++hits;
    ASSERT_LE(found[i], glm::dot(-inputs[i].ray.origin, inputs[i].ray.direction)) << "seed 5, ray " << i;
  }
  EXPECT_GT(hits, inputs.size() / 4);
}

TEST_P(Case04, AnEyeInsideSeesTheSphereHalfwayToItsCentre) {
  const auto seen = [&](float offset, float distance) { return hitAlongZ(GetParam(), offset, distance, 1.0f); };
  EXPECT_EQ(seen(0.0f, 0.5f), 0.25f);
  EXPECT_FLOAT_EQ(seen(0.0f, 1.9f), 0.95f);
  EXPECT_EQ(seen(0.0f, 2.0f), 1.0f);
  EXPECT_EQ(seen(0.0f, 0.0f), kNoHit);  // there is no direction to see it in
  EXPECT_EQ(seen(0.0f, -0.5f), kNoHit);
  EXPECT_EQ(seen(1.0f, 0.0f), kNoHit);
  // 30 degrees around its centre and no more.
  for (const float degrees : {0.0f, 15.0f, 29.9f, 30.1f, 60.0f}) {
    const float angle = glm::radians(degrees);
    const float t = evaluate<SphereProbe>(
        GetParam(),
        SphereProbe::Input{{{0.0f, 0.0f, 0.0f}, {std::sin(angle), 0.0f, std::cos(angle)}}, {0.0f, 0.0f, 0.01f}, 1.0f});
    EXPECT_EQ(t < kNoHit, degrees < 30.0f) << degrees;
  }
  recordExact("intersectSphere, the eye inside", "closed form", GetParam());
}

TEST_P(Case05, AnEyeOnTheSurfaceSeesTheSphereHalfwayToItsCentre) {
  EXPECT_EQ(hitAlongZ(GetParam(), 0.0f, 1.0f, 1.0f), 0.5f);
  EXPECT_EQ(hitAlongZ(GetParam(), 0.0f, std::nextafter(1.0f, 2.0f), 1.0f), 0.5f * std::nextafter(1.0f, 2.0f));
  EXPECT_EQ(hitAlongZ(GetParam(), 0.0f, -1.0f, 1.0f), kNoHit);  // and none behind it
  recordExact("intersectSphere, the eye on the surface", "closed form", GetParam());
}

TEST_P(Case06, NoRadiusNoHit) {
  for (const float radius : {0.0f, -0.0f, -1.0f, std::nanf(""), -kNoHit})
    EXPECT_EQ(hitAlongZ(GetParam(), 0.0f, 5.0f, radius), kNoHit) << radius;
  recordExact("intersectSphere, no radius", "definition", GetParam());
}

TEST_P(Case08, WhatIsBehindIsMissed) {
  for (const float distance : {-5.0f, -1e-30f, -1e4f, -1e7f})
    EXPECT_EQ(hitAlongZ(GetParam(), 0.0f, distance, 1.0f), kNoHit) << distance;
  recordExact("intersectSphere, behind", "definition", GetParam());
}

TEST_P(Case09, PropertyADirectionOfAnyLengthMeetsTheSamePoint) {
  // Rays have unit directions. What makes them so takes vectors of any length.
  Worst worst;
  checkProperty([&] {
    const SphereCase c = *anySphereCase(-10, 10);
    const float t = evaluate<SphereProbe>(GetParam(), inputOf(c));
    for (const float scale : {1e18f, 1e-18f, 3.7e9f, 0x1p-50f}) {
      SphereCase other = c;
      other.ray.direction = glm::normalize(scale * c.ray.direction);
      const float s = evaluate<SphereProbe>(GetParam(), inputOf(other));
      if (verdictOf(c) == Verdict::undecided || verdictOf(other) == Verdict::undecided) continue;
      RC_ASSERT((s < kNoHit) == (t < kNoHit));
      if (s == kNoHit) continue;
      const double error = surfaceError(truthOf(other), s);
      RC_ASSERT(error * kUnitRoundoff <= kSphereSurfaceError);
      worst.see(error);
    }
  });
  record({"intersectSphere, direction scaled by 1e18 and 1e-18", "100 digits", "u of distance and radius",
          worst.value(), kSphereSurfaceError / kUnitRoundoff, GetParam()});
}

TEST_P(Case09, PropertyScalingByPowersOfTwoScalesTheDistance) {
  checkProperty([&] {
    const SphereCase c = *anySphereCase(-10, 10);
    const float t = evaluate<SphereProbe>(GetParam(), inputOf(c));
    for (const float scale : {0x1p-30f, 0x1p-10f, 0.5f, 1024.0f, 0x1p25f})
      RC_ASSERT(evaluate<SphereProbe>(GetParam(), SphereProbe::Input{{scale * c.ray.origin, c.ray.direction},
                                                                     scale * c.center,
                                                                     scale * c.radius}) == scale * t);
  });
  recordExact("intersectSphere, all scaled by powers of two", "itself", GetParam());
}

TEST_P(Case10, NoDirectionNoHit) {
  for (const float zero : {0.0f, -0.0f})
    for (const glm::vec3& center : {glm::vec3(0.0f, 0.0f, 5.0f), glm::vec3(0.0f), glm::vec3(1e30f, 0.0f, 0.0f)})
      EXPECT_EQ(evaluate<SphereProbe>(GetParam(), SphereProbe::Input{{glm::vec3(0.0f), glm::vec3(zero)}, center, 1.0f}),
                kNoHit);
  recordExact("intersectSphere, no direction", "definition", GetParam());
}

TEST_P(Case11, FarFromTheCoordinatesOrigin) {
  const Ray ray{{1e7f, 0.0f, 0.0f}, {0.0f, 0.0f, 1.0f}};
  EXPECT_EQ(evaluate<SphereProbe>(GetParam(), SphereProbe::Input{ray, {1e7f, 0.0f, 16.0f}, 4.0f}), 12.0f);
  EXPECT_EQ(evaluate<SphereProbe>(GetParam(), SphereProbe::Input{ray, {1e7f + 8.0f, 0.0f, 16.0f}, 4.0f}), kNoHit);
  recordExact("intersectSphere at 1e7", "closed form", GetParam());
}

}  // namespace
}  // namespace warpscope
